// Pose, clocks, rotor speeds, battery, controller, structure.
#include "hidden_sizes.hpp"

namespace omniflight::proof {

namespace {

void pose(std::vector<Hidden>& out) {
  const auto tilt = [](const FamilyFlight& f, double a, const Shape& k, const FamilyFlown&) {
    return along(weight(f) * a * k.direction(0, true));
  };
  out.push_back({.id = "mocap_tilt",
                 .stage = "sensing",
                 .realisation = "world of the motion capture askew",
                 .law = true,
                 .measure = Measure::formula,
                 .smallest = 2e-4,
                 .typical = 0.01,
                 .largest = 0.2,
                 .apply = [](FamilyFlight& f, double a,
                             const Shape& k) { f.world.sensors.mocap_rotation_W = a * k.direction(0, true); },
                 .size = tilt});
  out.push_back({.id = "mocap_tilt",
                 .stage = "sensing",
                 .realisation = "world of the motion capture askew and turned",
                 .measure = Measure::formula,
                 .smallest = 2e-4,
                 .typical = 0.01,
                 .largest = 0.2,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       f.world.sensors.mocap_rotation_W = a * k.direction(0, true) + 0.5 * a * Vec3::UnitZ();
                     },
                 .size = tilt});
  out.push_back({.id = "mocap_offset",
                 .stage = "sensing",
                 .realisation = "markers beside the origin",
                 .law = true,
                 .measure = Measure::formula,
                 .smallest = 2e-4,
                 .typical = 0.01,
                 .largest = 0.15,
                 .apply = [](FamilyFlight& f, double a,
                             const Shape& k) { f.world.sensors.mocap_offset_B = a * k.direction(0); },
                 .size = [](const FamilyFlight& f, double a, const Shape&,
                            const FamilyFlown& n) { return forces(mass(f) * a * n.lever); }});
  out.push_back({.id = "mocap_offset",
                 .stage = "sensing",
                 .realisation = "markers turned against the body",
                 .measure = Measure::formula,
                 .smallest = 2e-4,
                 .typical = 0.01,
                 .largest = 0.2,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       f.world.sensors.mocap_turn_B = a * k.direction(0, true);
                       f.world.sensors.mocap_offset_B = 0.3 * a * arm(f) * k.direction(2);
                     },
                 .size = tilt});
  out.push_back(
      {.id = "clock_offset",
       .stage = "sensing",
       .realisation = "the board's stamps are late",
       .law = true,
       .combines = false,
       .measure = Measure::formula,
       .smallest = 5e-4,
       .typical = 0.01,
       .largest = 0.08,
       .apply = [](FamilyFlight& f, double a, const Shape&) { f.world.sensors.board_clock_offset = a; },
       .parameters = [](const FamilyFlight&, double a,
                        const Shape&) { return Parameters{scalar("offset", a)}; },
       .size = [](const FamilyFlight& f, double a, const Shape&,
                  const FamilyFlown& n) { return late(f, a, n); }});
  out.push_back({.id = "clock_offset",
                 .stage = "sensing",
                 .realisation = "poses stamped on arrival",
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 0.002,
                 .typical = 0.01,
                 .largest = 0.08,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       f.world.sensors.mocap_extra_latency = f.step * std::round(a / f.step);
                       f.sensors.mocap_stamp_jitter = 0.1 * a;
                     },
                 .size = [](const FamilyFlight& f, double a, const Shape&,
                            const FamilyFlown& n) { return late(f, a, n); }});
  out.push_back({.id = "stale_samples",
                 .stage = "sensing",
                 .realisation = "poses that repeat the last one",
                 .law = true,
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 0.005,
                 .typical = 0.2,
                 .largest = 0.8,
                 .apply = [](FamilyFlight& f, double a, const Shape&) { f.world.sensors.pose_repeat = a; },
                 .size =
                     [](const FamilyFlight& f, double a, const Shape&, const FamilyFlown& n) {
                       return own(a * n.speed / std::sqrt(3.0) / f.sensors.mocap_rate /
                                  f.sensors.mocap_position_noise);
                     }});
  out.push_back(
      {.id = "stale_samples",
       .stage = "sensing",
       .realisation = "the pose stands still now and then",
       .combines = false,
       .measure = Measure::formula,
       .smallest = 0.02,
       .typical = 0.15,
       .largest = 0.35,
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             const double length = f.path.duration - f.lead;
             for (int i = 0; i < 12; ++i) {
               const double at =
                   1 + f.lead + length * (0.06 + 0.075 * i + 0.03 * k.u[static_cast<std::size_t>(i % 8)]);
               f.world.sensors.faults.push_back(
                   {.sensor = SensorFault::Sensor::mocap, .from = at, .until = at + a, .frozen = true});
             }
           },
       .size =
           [](const FamilyFlight& f, double a, const Shape&, const FamilyFlown& n) {
             return own(0.3 * a * n.speed / std::sqrt(3.0) / (f.sensors.mocap_position_noise * 40));
           }});
}

void rest(std::vector<Hidden>& out) {
  const auto hidden_thrust = [](const FamilyFlight& f, double a, const Shape&, const FamilyFlown&) {
    const double lost = weight(f) / f.vehicle.nominal.rotor_count() * (1 - (1 - a) * (1 - a));
    SensorSize s;
    s.wrench = {0, 0, lost, 0.7 * arm(f) * lost, 0.7 * arm(f) * lost, 0};
    return s;
  };
  out.push_back({.id = "rotor_speed_sensor_fault",
                 .stage = "sensing",
                 .realisation = "one sensor reads a share",
                 .law = true,
                 .measure = Measure::formula,
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 0.5,
                 .possible = has_speed,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       f.world.sensors.faults.push_back(
                           {.sensor = SensorFault::Sensor::rotor_speed,
                            .rotor = k.whole(0, 1, f.vehicle.nominal.rotor_count()),
                            .scale = 1 - a});
                     },
                 .size = hidden_thrust});
  out.push_back({.id = "rotor_speed_sensor_fault",
                 .stage = "sensing",
                 .realisation = "one sensor misses pulses now and then",
                 .measure = Measure::formula,
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 0.5,
                 .possible = has_speed,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       const double length = f.path.duration - f.lead;
                       for (int i = 0; i < 8; ++i)
                         f.world.sensors.faults.push_back(
                             {.sensor = SensorFault::Sensor::rotor_speed,
                              .rotor = k.whole(0, 1, f.vehicle.nominal.rotor_count()),
                              .from = 1 + f.lead + length * (0.02 + 0.12 * i),
                              .until = 1 + f.lead + length * (0.10 + 0.12 * i),
                              .scale = 1 - a});
                     },
                 .size = hidden_thrust});
  const auto battery = [](const FamilyVehicle&, const Coordinates& c) { return c.signals != "imu+duty"; };
  const auto volts = [](const FamilyFlight&, double a, const Shape&, const FamilyFlown&) {
    return own(a / 0.01);
  };
  out.push_back({.id = "battery_sensor_fault",
                 .stage = "sensing",
                 .realisation = "voltage reads a share",
                 .law = true,
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 0.002,
                 .typical = 0.05,
                 .largest = 0.5,
                 .possible = battery,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       f.logging.battery = true;
                       f.world.sensors.faults.push_back(
                           {.sensor = SensorFault::Sensor::battery, .scale = 1 - a});
                     },
                 .size = volts});
  out.push_back({.id = "battery_sensor_fault",
                 .stage = "sensing",
                 .realisation = "voltage stands still",
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 0.002,
                 .typical = 0.05,
                 .largest = 0.5,
                 .possible = battery,
                 .apply =
                     [](FamilyFlight& f, double, const Shape& k) {
                       f.logging.battery = true;
                       const double length = f.path.duration - f.lead;
                       f.world.sensors.faults.push_back({.sensor = SensorFault::Sensor::battery,
                                                         .from = 1 + f.lead + k.between(0, 0.1, 0.3) * length,
                                                         .frozen = true});
                     },
                 .size = volts});
  const auto gains_known = [](const FamilyVehicle&, const Coordinates& c) {
    return c.told_gains == "told" && c.reference &&
           (c.controller == "geometric" || c.controller == "cascade");
  };
  out.push_back({.id = "controller_mismatch",
                 .stage = "control",
                 .realisation = "gains that are not those told",
                 .law = true,
                 .combines = false,
                 .measure = Measure::control,
                 .smallest = 1e-3,
                 .typical = 0.2,
                 .largest = 0.6,
                 .possible = gains_known,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   Gains& g = f.flown.gains;
                   if (k.u[0] < 0.5)
                     g.kp *= 1 - a, g.kv *= 1 - a;
                   else
                     g.kR *= 1 - a, g.kw *= 1 - a;
                   f.logging.reasons = true;
                 }});
  out.push_back({.id = "controller_mismatch",
                 .stage = "control",
                 .realisation = "another mass in the controller, no feed-forward, yaw held back",
                 .combines = false,
                 .measure = Measure::control,
                 .smallest = 1e-3,
                 .typical = 0.2,
                 .largest = 0.7,
                 .possible = gains_known,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   f.flown.yaw_cut = 1 - a;
                   if (a > 0.15)
                     f.flown.feedforward = k.u[0] < 0.5 ? !f.told.feedforward : f.told.feedforward;
                   f.logging.reasons = true;
                 }});
  out.push_back({.id = "structural_mode",
                 .stage = "wrench",
                 .realisation = "arms that bend",
                 .law = true,
                 .combines = false,
                 .slow = true,
                 .smallest = 0.005,
                 .typical = 0.1,
                 .largest = 0.35,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       FlexibleArms arms;
                       arms.pod_mass = std::max(1e-4, a * mass(f) / f.vehicle.nominal.rotor_count());
                       arms.frequency = k.between(0, 12, 22);
                       arms.damping_ratio = k.between(1, 0.03, 0.08);
                       f.world.flexible_arms = arms;
                     },
                 .variables = {},
                 .along = {"inertia_error"}});
  out.push_back({.id = "structural_mode",
                 .stage = "wrench",
                 .realisation = "a loose battery that shakes at 9 to 14 Hz",
                 .combines = false,
                 .slow = true,
                 .smallest = 0.005,
                 .typical = 0.1,
                 .largest = 0.35,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   f.world.body.sloshing_mass = a * mass(f);
                   f.world.body.sloshing_frequency = k.between(0, 9, 14);
                   f.world.body.sloshing_damping_ratio = k.between(1, 0.04, 0.1);
                 }});
}

}  // namespace

void hide_sensing(std::vector<Hidden>& out) {
  pose(out);
  rest(out);
}

}  // namespace omniflight::proof
