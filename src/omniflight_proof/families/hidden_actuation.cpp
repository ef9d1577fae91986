// Motors, electronics, battery, tilt servo.
#include "hidden.hpp"

namespace omniflight::proof {

namespace {

using Measure = Hidden::Measure;

double nominal_lag(const FamilyFlight& f) { return f.vehicle.nominal.rotors[0].time_constant; }

void motors(std::vector<Hidden>& out) {
  out.push_back(
      {.id = "motor_lag",
       .stage = "actuation",
       .realisation = "slower motors",
       .law = true,
       .measure = Measure::command,
       .smallest = 0.01,
       .typical = 0.6,
       .largest = 2.5,
       .apply =
           [](FamilyFlight& f, double a, const Shape&) {
             each_rotor(f, [&](RotorChange& c, int) { c.time_constant = nominal_lag(f) * (1 + a); });
           },
       .parameters = [](const FamilyFlight& f, double a,
                        const Shape&) { return Parameters{scalar("time_constant", a * nominal_lag(f))}; }});
  out.push_back({.id = "motor_lag",
                 .stage = "actuation",
                 .realisation = "motors that only slow down by their drag",
                 .measure = Measure::command,
                 .smallest = 0.02,
                 .typical = 0.8,
                 .largest = 4,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [&](RotorChange& c, int) {
                     c.time_constant = nominal_lag(f) * (1 + 0.3 * a);
                     c.slowing_factor = std::min(5.0, 1 + a);
                   });
                 }});
  out.push_back({.id = "thrust_dead_zone",
                 .stage = "actuation",
                 .realisation = "speeds too small to be held",
                 .law = true,
                 .measure = Measure::command,
                 .smallest = 0.02,
                 .typical = 0.3,
                 .largest = 0.9,
                 .possible = turns_back,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [&](RotorChange& c, int) { c.dead_speed = a * hover_speed(f); });
                 }});
  out.push_back({.id = "thrust_dead_zone",
                 .stage = "actuation",
                 .realisation = "sensorless motors that start again late",
                 .measure = Measure::command,
                 .smallest = 0.02,
                 .typical = 0.3,
                 .largest = 0.8,
                 .possible = turns_back,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   each_rotor(f, [&](RotorChange& c, int) {
                     c.dead_speed = 0.6 * a * hover_speed(f);
                     c.restart = a * k.between(0, 0.05, 0.15);
                   });
                 }});
  out.push_back({.id = "transport_delay",
                 .stage = "actuation",
                 .realisation = "one board answers late",
                 .law = true,
                 .measure = Measure::command,
                 .smallest = 0.001,
                 .typical = 0.01,
                 .largest = 0.04,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   each_rotor(
                       f, [a](RotorChange& c, int) { c.delay = a; }, k.whole(0, 0, 1));
                 }});
  out.push_back({.id = "transport_delay",
                 .stage = "actuation",
                 .realisation = "a slow bus: late, and held between frames",
                 .measure = Measure::command,
                 .smallest = 0.002,
                 .typical = 0.01,
                 .largest = 0.03,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       each_rotor(f, [a](RotorChange& c, int i) {
                         c.delay = 0.7 * a + 0.0005 * (i % 3);
                         c.hold = 0.6 * a;
                       });
                     },
                 .along = {"command_quantisation"}});
  out.push_back({.id = "command_quantisation",
                 .stage = "actuation",
                 .realisation = "coarse speed commands",
                 .law = true,
                 .combines = false,
                 .measure = Measure::command,
                 .smallest = 5e-4,
                 .typical = 0.03,
                 .largest = 0.25,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [&](RotorChange& c, int) { c.quantum = a * hover_speed(f); });
                 }});
  out.push_back({.id = "command_quantisation",
                 .stage = "actuation",
                 .realisation = "commands taken over in slow frames, coarse as well",
                 .combines = false,
                 .measure = Measure::command,
                 .smallest = 5e-4,
                 .typical = 0.03,
                 .largest = 0.2,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   each_rotor(f, [&](RotorChange& c, int) {
                     c.quantum = 0.6 * a * hover_speed(f);
                     c.hold = std::min(0.05, a * k.between(0, 0.3, 0.6));
                   });
                 }});
  out.push_back({.id = "actuator_saturation",
                 .stage = "actuation",
                 .realisation = "motors that reach less speed",
                 .law = true,
                 .combines = false,
                 .measure = Measure::command,
                 .smallest = 0.01,
                 .typical = 0.3,
                 .largest = 0.6,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [&](RotorChange& c, int i) {
                     c.max_speed =
                         (1 - a) * f.vehicle.nominal.rotors[static_cast<std::size_t>(i)].max_speed();
                   });
                 }});
  out.push_back({.id = "actuator_saturation",
                 .stage = "actuation",
                 .realisation = "a current limit: speeds change slowly",
                 .combines = false,
                 .measure = Measure::command,
                 .smallest = 0.05,
                 .typical = 2,
                 .largest = 40,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [&](RotorChange& c, int) { c.slew = 10 * hover_speed(f) / a; });
                 }});
}

void battery_and_tilt(std::vector<Hidden>& out) {
  out.push_back({.id = "battery_sag",
                 .stage = "actuation",
                 .realisation = "battery with resistance and polarisation",
                 .combines = false,
                 .measure = Measure::command,
                 .smallest = 5e-3,
                 .typical = 0.2,
                 .largest = 3,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   BatterySag b;  // at the power of hovering: volts lost at once, slowly, and over a minute
                   const double power =
                       weight(f) *
                       std::sqrt(weight(f) / f.vehicle.nominal.rotor_count() /
                                 (2.4 * kPi * std::pow(f.vehicle.nominal.rotors[0].radius, 2))) /
                       0.4;
                   const double current = power / b.nominal;
                   b.resistance = std::min(1.0, 0.5 * a / current);
                   b.polarisation = std::min(1.0, 0.4 * a / current);
                   b.polarisation_time = k.between(1, 4, 14);
                   b.drop = std::min(1.0, k.between(0, 0.5, 1.2) * a / (60 * power));
                   f.world.battery = b;
                 }});
  out.push_back({.id = "battery_sag",
                 .stage = "actuation",
                 .realisation = "an old cell: the voltage falls with the charge",
                 .law = true,
                 .combines = false,
                 .measure = Measure::command,
                 .smallest = 5e-3,
                 .typical = 0.2,
                 .largest = 3,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   BatterySag b;
                   const double power =
                       weight(f) *
                       std::sqrt(weight(f) / f.vehicle.nominal.rotor_count() /
                                 (2.4 * kPi * std::pow(f.vehicle.nominal.rotors[0].radius, 2))) /
                       0.4;
                   b.resistance = 0;
                   b.polarisation = 0;
                   b.drop = std::min(1.0, 1.5 * a / (60 * power));
                   b.sensitivity = 1;
                   f.world.battery = b;
                 }});
  out.push_back({.id = "tilt_servo_lag",
                 .stage = "actuation",
                 .realisation = "a servo that follows late",
                 .law = true,
                 .smallest = 0.002,
                 .typical = 0.2,
                 .largest = 2,
                 .possible = tilt_moves,
                 .apply = [](FamilyFlight& f, double a, const Shape&) { f.world.tilt.time_constant += a; },
                 .parameters = [](const FamilyFlight&, double a,
                                  const Shape&) { return Parameters{scalar("time_constant", a)}; }});
  out.push_back({.id = "tilt_servo_lag",
                 .stage = "actuation",
                 .realisation = "worn gears and a weak servo",
                 .smallest = 0.002,
                 .typical = 0.2,
                 .largest = 1.2,
                 .possible = tilt_moves,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   f.world.tilt.time_constant += 0.6 * a;
                   f.world.tilt.backlash += 0.06 * a;
                 }});
  out.push_back({.id = "tilt_efficiency",
                 .stage = "wrench",
                 .realisation = "thrust that grows with the tilt",
                 .law = true,
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.5,
                 .possible = tilt_moves,
                 .apply = [](FamilyFlight& f, double a, const Shape&) { f.world.tilt.loss = a; }});
  out.push_back({.id = "tilt_efficiency",
                 .stage = "wrench",
                 .realisation = "slipstreams on the arms near one tilt",
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.5,
                 .possible = tilt_moves,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   f.world.tilt.loss = a;
                   f.world.tilt.loss_center = to_radians(k.between(0, 0, 25));
                   f.world.tilt.loss_width = to_radians(k.between(1, 18, 30));
                 }});
}

}  // namespace

void hide_actuation(std::vector<Hidden>& out) {
  motors(out);
  battery_and_tilt(out);
}

}  // namespace omniflight::proof
