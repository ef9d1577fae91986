// Air, tethers and loads, sensors and controller.
#include "case_mechanism_words.hpp"

namespace omniflight::proof {

using namespace words;

void hide_air(std::vector<Mechanism>& out) {
  out.push_back(
      {.id = "parasitic_drag",
       .stage = "wrench",
       .realisation = "drag of a sphere",
       .level = "L1",
       .smallest = 0.0005,
       .typical = 0.1,
       .largest = 0.25,
       .combines = false,  // so large a body is still a tenth of the noise, whatever stands beside it
       .apply = [](Setup& s, double a, const Shape&) { airframe(s).round_area = a; },
       .parameters = [](double a, const Shape&) { return Parameters{scalar("area", a)}; }});
  out.push_back({.id = "wind",
                 .stage = "wrench",
                 .realisation = "steady wind on a sphere, with a profile",
                 .level = "L3",
                 .smallest = 0.05,
                 .typical = 1.5,
                 .largest = 8,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       airframe(s).round_area = k.between(2, 0.02, 0.05);
                       Wind w;
                       w.velocity_W = a * k.direction(0, true);
                       w.profile_exponent = k.between(3, 0.05, 0.2);
                       s.world.wind = w;
                     },
                 .parameters = nothing});
  out.push_back({.id = "axial_inflow",
                 .stage = "wrench",
                 .realisation = "blade elements and momentum theory, along the axis",
                 .level = "L3",
                 .smallest = 0.05,
                 .typical = 0.6,
                 .largest = 3,
                 .apply =
                     [](Setup& s, double a, const Shape&) {
                       Blades b;
                       b.solidity_slope = a;
                       b.edgewise = false;
                       s.world.blades = b;
                     },
                 .parameters = nothing});
  out.push_back({.id = "downwash_interference",
                 .stage = "wrench",
                 .realisation = "contracting and spreading jets",
                 .level = "L3",
                 .smallest = 0.002,
                 .typical = 0.3,
                 .largest = 1,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       Jets j;
                       j.strength = a;
                       j.spread = k.between(0, 0.04, 0.1);
                       s.world.jets = j;
                     },
                 .parameters = nothing});
  out.push_back({.id = "ground_effect",
                 .stage = "wrench",
                 .realisation = "image of the slipstream in the floor",
                 .level = "L3",
                 .smallest = 0.05,
                 .typical = 2,
                 .largest = 8,
                 .apply =
                     [](Setup& s, double a, const Shape&) {
                       Planes p;
                       p.floor = a;
                       s.world.planes = p;
                     },
                 .parameters = nothing});
}

void hide_tethers(std::vector<Mechanism>& out) {
  out.push_back({.id = "constant_pull",
                 .stage = "wrench",
                 .realisation = "a constant-force spring far away",
                 .level = "L1",
                 .smallest = 0.003,
                 .typical = 0.3,
                 .largest = 3,
                 .combines = true,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       Pull p;
                       p.force_W = a * k.direction(0);
                       s.world.pulls.push_back(p);
                     },
                 .parameters =
                     [](double a, const Shape& k) {
                       return vector({"x", "y", "z"}, a * k.direction(0));
                     }});
  out.push_back({.id = "hung_cable",
                 .stage = "wrench",
                 .realisation = "20 links with floor contact",
                 .level = "L3",
                 .smallest = 0.001,
                 .typical = 0.05,
                 .largest = 0.5,
                 .combines = true,
                 .articulated = true,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       Cable c;
                       c.linear_density = a;
                       c.length = k.between(0, 1.7, 2.2);
                       c.links = 20;
                       c.drag_coefficient = 1;
                       c.attachment_B = Vec3(0, 0, k.between(1, -0.14, -0.10));
                       s.world.cable = c;
                     },
                 .parameters = [](double a, const Shape&) { return Parameters{scalar("linear_density", a)}; },
                 .along = {"attachment_torque"}});  // it hangs from below the middle
  out.push_back({.id = "overhead_rope",
                 .stage = "wrench",
                 .realisation = "20 links between vehicle and ceiling",
                 .level = "L3",
                 .smallest = 0.001,
                 .typical = 0.05,
                 .largest = 0.5,
                 .articulated = true,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       OverheadRope r;
                       r.linear_density = a;
                       r.length = k.between(0, 3.1, 3.6);
                       s.world.overhead_rope = r;
                     },
                 .parameters = [](double a, const Shape&) { return Parameters{scalar("linear_density", a)}; },
                 .along = {"attachment_torque"}});
  out.push_back({.id = "slung_load",
                 .stage = "wrench",
                 .realisation = "a ball on a swivelling rod",
                 .level = "L3",
                 .smallest = 0.0005,
                 .typical = 0.03,
                 .largest = 0.4,
                 .articulated = true,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       SlungBall b;
                       b.mass = a;
                       b.length = k.between(0, 0.14, 0.28);
                       b.attachment_B = Vec3(0, 0, -0.05);
                       s.world.slung_ball = b;
                     },
                 .parameters =
                     [](double a, const Shape& k) {
                       return Parameters{scalar("mass", a), scalar("length", k.between(0, 0.14, 0.28))};
                     },
                 .along = {"attachment_torque"}});
}

namespace {

using Sensors = decltype(Setup::sensors);
using WorldSensors = decltype(decltype(Setup::world)::sensors);

/// A constant error of an inertial sensor, `strength` times the noise for each of its units. It is the whole
/// of the bias: what a calibration leaves is taken out.
Mechanism sensor_bias(const char* id, double typical, double largest, double strength,
                      Vec3 Sensors::*calibrated, Vec3 WorldSensors::*bias) {
  return {.id = id,
          .stage = "sensing",
          .realisation = "bias beyond what is told",
          .level = "L1",
          .smallest = 0,
          .typical = typical,
          .largest = largest,
          .measure = Measure::formula,
          .apply =
              [=](Setup& s, double a, const Shape& k) {
                (s.sensors.*calibrated).setZero();
                s.world.sensors.*bias = a * k.direction(0);
              },
          .parameters =
              [](double a, const Shape& k) {
                return vector({"bias_x", "bias_y", "bias_z"}, a * k.direction(0));
              },
          .size = [strength](double a, const Shape& k,
                             const Flown&) { return strength * a * k.direction(0).cwiseAbs().maxCoeff(); }};
}

}  // namespace

void hide_sensing(std::vector<Mechanism>& out, const vehicle::Vehicle& v) {
  const double mass = v.mass, hover = v.mass * kGravity / v.rotor_count() / std::cos(to_radians(30));
  out.push_back(sensor_bias("accelerometer_error", 0.1, 5, mass / kForceNoise, &Sensors::accelerometer_bias,
                            &WorldSensors::accelerometer_bias));
  // over its own noise: it is no wrench
  out.push_back(sensor_bias("gyro_error", 0.01, 1, 1 / 0.004, &Sensors::gyro_bias, &WorldSensors::gyro_bias));
  out.push_back({.id = "mocap_tilt",
                 .stage = "sensing",
                 .realisation = "world of the motion capture askew",
                 .level = "L1",
                 .smallest = 0,
                 .typical = 0.01,
                 .largest = 0.3,
                 .measure = Measure::formula,
                 .apply = [](Setup& s, double a,
                             const Shape& k) { s.world.sensors.mocap_rotation_W = a * k.direction(0, true); },
                 .parameters = nothing,
                 .size =
                     [mass](double a, const Shape& k, const Flown&) {
                       return mass * kGravity * a * k.direction(0, true).cwiseAbs().maxCoeff() / kForceNoise;
                     }});
  out.push_back(
      {.id = "imu_lever_arm",
       .stage = "sensing",
       .realisation = "the IMU off the origin",
       .level = "L1",
       .smallest = 0,
       .typical = 0.02,
       .largest = 0.5,
       .measure = Measure::formula,
       .needs_tilt = true,
       .apply = [](Setup& s, double a, const Shape& k) { s.world.sensors.imu_p_B = a * k.direction(0); },
       .parameters = nothing,
       .size = [mass](
                   double a, const Shape&,
                   const Flown& nominal) { return mass * a * nominal.dw / std::sqrt(3.0) / kForceNoise; }});
  out.push_back({.id = "rotor_speed_sensor_fault",
                 .stage = "sensing",
                 .realisation = "one sensor reads a share",
                 .level = "L1",
                 .smallest = 0,
                 .typical = 0.1,
                 .largest = 0.6,
                 .measure = Measure::formula,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       SensorFault f;
                       f.sensor = SensorFault::Sensor::rotor_speed;
                       f.rotor = k.whole(0, 1, 8);
                       f.scale = 1 - a;
                       s.world.sensors.faults.push_back(f);
                     },
                 .parameters = nothing,
                 .size = [hover](double a, const Shape&, const Flown&) {  // torque of the thrust it hides
                   return hover * (1 - (1 - a) * (1 - a)) * 0.125 / kTorqueNoise;
                 }});
  out.push_back({.id = "controller_mismatch",
                 .stage = "control",
                 .realisation = "gains that are not those told",
                 .level = "L1",
                 .smallest = 0.001,
                 .typical = 0.2,
                 .largest = 0.6,
                 .measure = Measure::control,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       const double scale = 1 - a;
                       if (k.u[0] < 0.5)
                         s.flown.kp *= scale, s.flown.kv *= scale;
                       else
                         s.flown.kR *= scale, s.flown.kw *= scale;
                     },
                 .parameters = nothing});
}

}  // namespace omniflight::proof
