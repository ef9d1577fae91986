#include "case_mechanism.hpp"

#include <cmath>

namespace omniflight::proof {
namespace {

using Setup = FlightSetup;
using Measure = Mechanism::Measure;
using Parameters = std::vector<TrueParameter>;

TrueParameter scalar(const char* name, double value) { return {name, value, std::abs(value)}; }
Parameters vector(std::initializer_list<const char*> names, const Vec3& v) {
  Parameters out;
  int k = 0;
  for (const char* name : names) out.push_back({name, v[k++], v.norm()});
  return out;
}
Parameters nothing(double, const Shape&) { return {}; }

/// Rotor changes for those of a board (-1: all).
void each_rotor(Setup& s, const vehicle::Vehicle& vehicle, int board,
                const std::function<void(RotorChange&)>& change) {
  for (int i = 0; i < vehicle.rotor_count(); ++i) {
    if (board >= 0 && vehicle.rotors[static_cast<std::size_t>(i)].board != board) continue;
    RotorChange c;
    c.rotor = i + 1;
    change(c);
    s.world.rotors.push_back(c);
  }
}
RotorChange one_rotor(const Shape& shape) {
  RotorChange c;
  c.rotor = shape.whole(0, 1, 8);
  return c;
}
Airframe& airframe(Setup& s) {
  if (!s.world.airframe) s.world.airframe.emplace();
  return *s.world.airframe;
}

void rigid_body(std::vector<Mechanism>& out, const vehicle::Vehicle& v) {
  out.push_back({.id = "payload_mass",
                 .stage = "wrench",
                 .realisation = "a ball welded to the body",
                 .level = "L1",
                 .smallest = 0.0005,
                 .typical = 0.05,
                 .largest = 0.5,
                 .combines = true,
                 .apply = [](Setup& s, double a, const Shape&) { s.world.body.payload = a; },
                 .parameters = [](double a, const Shape&) { return Parameters{scalar("mass", a)}; }});
  out.push_back(
      {.id = "com_offset",
       .stage = "wrench",
       .realisation = "the body's mass elsewhere",
       .level = "L1",
       .smallest = 1e-5,
       .typical = 0.003,
       .largest = 0.04,
       .combines = true,
       .apply = [](Setup& s, double a, const Shape& k) { s.world.body.com_shift_B = a * k.direction(0); },
       .parameters =
           [](double a, const Shape& k) {
             return vector({"x", "y", "z"}, a * k.direction(0));
           }});
  const Vec3 J = v.inertia.diagonal();
  out.push_back(
      {.id = "inertia_error",
       .stage = "wrench",
       .realisation = "other moments of inertia",
       .level = "L1",
       .smallest = 0.001,
       .typical = 0.2,
       .largest = 0.45,
       .combines = true,
       .apply =
           [](Setup& s, double a, const Shape& k) {
             s.world.body.inertia_scale = Vec3::Constant(1 + a * k.sign(0)) + 0.15 * a * k.direction(1);
           },
       .parameters =
           [J](double a, const Shape& k) {
             return vector({"xx", "yy", "zz"},
                           J.cwiseProduct(Vec3(Vec3::Constant(a * k.sign(0)) + 0.15 * a * k.direction(1))));
           }});
  out.push_back({.id = "rotor_axis_misalignment",
                 .stage = "wrench",
                 .realisation = "one rotor mounted askew",
                 .level = "L1",
                 .smallest = 0.0005,
                 .typical = 0.03,
                 .largest = 0.25,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       RotorChange c = one_rotor(k);
                       c.axis_tilt_B = a * k.direction(1, true);
                       s.world.rotors.push_back(c);
                     },
                 .parameters = nothing});
  out.push_back({.id = "rotor_position_error",
                 .stage = "wrench",
                 .realisation = "one rotor mounted elsewhere",
                 .level = "L1",
                 .smallest = 0.0005,
                 .typical = 0.01,
                 .largest = 0.04,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       RotorChange c = one_rotor(k);
                       c.shift_B = a * k.direction(1, true);
                       s.world.rotors.push_back(c);
                     },
                 .parameters = nothing});
  out.push_back(
      {.id = "tilt_offset",
       .stage = "wrench",
       .realisation = "linkage of the tilt mounted askew",
       .level = "L1",
       .smallest = 0.0003,
       .typical = 0.02,
       .largest = 0.15,
       .combines = true,
       .apply = [](Setup& s, double a, const Shape& k) { s.world.tilt.offset = a * k.sign(0); },
       .parameters = [](double a, const Shape& k) { return Parameters{scalar("offset", a * k.sign(0))}; }});
}

void actuation(std::vector<Mechanism>& out, const vehicle::Vehicle& v) {
  out.push_back(
      {.id = "thrust_scale",
       .stage = "wrench",
       .realisation = "all propellers weaker",
       .level = "L1",
       .smallest = 0.0005,
       .typical = 0.05,
       .largest = 0.35,
       .apply = [&v](Setup& s, double a,
                     const Shape&) { each_rotor(s, v, -1, [a](RotorChange& c) { c.thrust_scale = 1 - a; }); },
       .parameters = [](double a, const Shape&) { return Parameters{scalar("scale", -a)}; }});
  out.push_back({.id = "rotor_thrust_scale",
                 .stage = "wrench",
                 .realisation = "one propeller weaker",
                 .level = "L1",
                 .smallest = 0.0005,
                 .typical = 0.05,
                 .largest = 0.6,
                 .combines = true,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       RotorChange c = one_rotor(k);
                       c.thrust_scale = 1 - a;
                       s.world.rotors.push_back(c);
                     },
                 .parameters = nothing});
  out.push_back({.id = "drag_torque_scale",
                 .stage = "wrench",
                 .realisation = "propellers of another drag",
                 .level = "L1",
                 .smallest = 0.001,
                 .typical = 0.2,
                 .largest = 0.55,
                 .combines = true,
                 .apply =
                     [&v](Setup& s, double a, const Shape& k) {
                       const double scale = std::max(0.05, 1 + a * k.sign(0));
                       each_rotor(s, v, -1, [scale](RotorChange& c) { c.drag_torque_scale = scale; });
                     },
                 .parameters =
                     [](double a, const Shape& k) {
                       return Parameters{scalar("scale", std::max(0.05, 1 + a * k.sign(0)) - 1)};
                     }});
  out.push_back({.id = "thrust_curve",
                 .stage = "wrench",
                 .realisation = "another exponent of thrust over speed",
                 .level = "L1",
                 .smallest = 0.001,
                 .typical = 0.1,
                 .largest = 0.6,
                 .apply =
                     [&v](Setup& s, double a, const Shape& k) {
                       const double exponent = 2 + a * k.sign(0);
                       each_rotor(s, v, -1, [exponent](RotorChange& c) { c.exponent = exponent; });
                     },
                 .parameters = nothing});
  out.push_back(
      {.id = "rotor_inertia",
       .stage = "wrench",
       .realisation = "spinning parts with inertia",
       .level = "L1",
       .smallest = 1e-7,
       .typical = 2e-5,
       .largest = 2e-4,
       .combines = true,
       .apply = [&v](Setup& s, double a,
                     const Shape&) { each_rotor(s, v, -1, [a](RotorChange& c) { c.inertia = a; }); },
       .parameters = [](double a, const Shape&) { return Parameters{scalar("inertia", a)}; }});
  out.push_back(
      {.id = "motor_lag",
       .stage = "actuation",
       .realisation = "slower motors",
       .level = "L1",
       .smallest = 0.0005,
       .typical = 0.02,
       .largest = 0.06,
       .measure = Measure::command,
       .combines = true,
       .apply =
           [&v](Setup& s, double a, const Shape&) {
             each_rotor(s, v, -1, [&, a](RotorChange& c) {
               c.time_constant = v.rotors[static_cast<std::size_t>(c.rotor - 1)].time_constant + a;
             });
           },
       .parameters = [](double a, const Shape&) { return Parameters{scalar("time_constant", a)}; }});
  out.push_back({.id = "transport_delay",
                 .stage = "actuation",
                 .realisation = "one board answers late",
                 .level = "L1",
                 .smallest = 0.0005,
                 .typical = 0.01,
                 .largest = 0.05,
                 .measure = Measure::command,
                 .apply =
                     [&v](Setup& s, double a, const Shape& k) {
                       each_rotor(s, v, k.whole(0, 0, 1), [a](RotorChange& c) { c.delay = a; });
                     },
                 .parameters =
                     [](double a, const Shape& k) {
                       const double delay = std::round(a / 0.0005) * 0.0005;  // of the plant's steps
                       const int board = k.whole(0, 0, 1);
                       return Parameters{{"board_0", board == 0 ? delay : 0, delay},
                                         {"board_1", board == 1 ? delay : 0, delay}};
                     }});
  out.push_back(
      {.id = "command_quantisation",
       .stage = "actuation",
       .realisation = "coarse speed commands",
       .level = "L1",
       .smallest = 0.05,
       .typical = 20,
       .largest = 120,
       .measure = Measure::command,
       .apply = [&v](Setup& s, double a,
                     const Shape&) { each_rotor(s, v, -1, [a](RotorChange& c) { c.quantum = a; }); },
       .parameters = nothing});
  out.push_back(
      {.id = "tilt_servo_lag",
       .stage = "actuation",
       .realisation = "a servo that follows late",
       .level = "L1",
       .smallest = 0.002,
       .typical = 0.2,
       .largest = 2,
       .needs_tilt = true,
       .apply = [](Setup& s, double a, const Shape&) { s.world.tilt.time_constant = a; },
       .parameters = [](double a, const Shape&) { return Parameters{scalar("time_constant", a)}; }});
  out.push_back({.id = "battery_sag",
                 .stage = "actuation",
                 .realisation = "battery with resistance and polarisation",
                 .level = "L3",
                 .smallest = 0.0005,
                 .typical = 0.1,
                 .largest = 3,
                 .measure = Measure::command,
                 .apply =
                     [](Setup& s, double a, const Shape& k) {
                       BatterySag b;
                       b.resistance = 0.03 * a;
                       b.drop = k.between(0, 1.5e-4, 4e-4) * a;
                       b.polarisation = 0.02 * a;
                       b.polarisation_time = k.between(1, 4, 14);
                       s.world.battery = b;
                     },
                 .parameters = nothing});
}

void air(std::vector<Mechanism>& out) {
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

void tethers(std::vector<Mechanism>& out) {
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

void sensing(std::vector<Mechanism>& out, const vehicle::Vehicle& v) {
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

}  // namespace

void unknown_laws(std::vector<Mechanism>& out);  // case_unknown.cpp

Vec3 Shape::direction(int k, bool flat) const {
  const double azimuth = between(k, 0, 2 * kPi), z = flat ? 0.0 : between(k + 1, -1, 1);
  const double across = std::sqrt(std::max(0.0, 1 - z * z));
  return {across * std::cos(azimuth), across * std::sin(azimuth), z};
}

Shape draw_shape(Random& random, bool sealed) {
  Shape s;
  for (double& u : s.u) {
    const double in = random.uniform(0, 4);  // four of eight strips, every other one
    u = (2 * std::floor(in) + (in - std::floor(in)) + (sealed ? 1 : 0)) / 8;
  }
  return s;
}

double in_sigma(const std::array<double, 6>& w) {
  double out = 0;
  for (std::size_t c = 0; c < 6; ++c) out = std::max(out, w[c] / (c < 3 ? kForceNoise : kTorqueNoise));
  return out;
}

std::vector<Mechanism> mechanisms(const vehicle::Vehicle& vehicle) {
  std::vector<Mechanism> out;
  rigid_body(out, vehicle);
  actuation(out, vehicle);
  air(out);
  tethers(out);
  sensing(out, vehicle);
  unknown_laws(out);
  return out;
}

}  // namespace omniflight::proof
