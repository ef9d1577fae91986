// Mass, geometry and actuation, and the list of all mechanisms.
#include "case_mechanism_words.hpp"

namespace omniflight::proof {

using namespace words;

void hide_rigid_body(std::vector<Mechanism>& out, const vehicle::Vehicle& v) {
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

void hide_actuation(std::vector<Mechanism>& out, const vehicle::Vehicle& v) {
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

double in_sigma(const std::array<double, 6>& w) {
  double out = 0;
  for (std::size_t c = 0; c < 6; ++c) out = std::max(out, w[c] / (c < 3 ? kForceNoise : kTorqueNoise));
  return out;
}

std::vector<Mechanism> mechanisms(const vehicle::Vehicle& vehicle) {
  std::vector<Mechanism> out;
  hide_rigid_body(out, vehicle);
  hide_actuation(out, vehicle);
  hide_air(out);
  hide_tethers(out);
  hide_sensing(out, vehicle);
  unknown_laws(out);
  return out;
}

}  // namespace omniflight::proof
