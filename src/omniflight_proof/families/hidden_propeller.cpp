// Propellers.
#include "hidden.hpp"

namespace omniflight::proof {

void hide_propellers(std::vector<Hidden>& out) {
  out.push_back(
      {.id = "thrust_scale",
       .stage = "wrench",
       .realisation = "all propellers weaker",
       .law = true,
       .combines = false,
       .smallest = 5e-4,
       .typical = 0.05,
       .largest = 0.3,
       .apply = [](FamilyFlight& f, double a,
                   const Shape&) { each_rotor(f, [a](RotorChange& c, int) { c.thrust_scale = 1 - a; }); },
       .parameters = [](const FamilyFlight&, double a,
                        const Shape&) { return Parameters{scalar("scale", -a)}; }});
  out.push_back({.id = "thrust_scale",
                 .stage = "wrench",
                 .realisation = "a set of worn propellers, none like the other",
                 .combines = false,
                 .smallest = 5e-4,
                 .typical = 0.05,
                 .largest = 0.25,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       each_rotor(f, [&](RotorChange& c, int i) {
                         c.thrust_scale = 1 - a * (1 + 0.05 * std::sin(2.3 * i + 6 * k.u[0]));
                         c.drag_torque_scale = 1 + 0.3 * a;
                       });
                     },
                 .along = {"drag_torque_scale", "rotor_thrust_scale"}});
  out.push_back({.id = "rotor_thrust_scale",
                 .stage = "wrench",
                 .realisation = "one propeller weaker",
                 .law = true,
                 .smallest = 5e-4,
                 .typical = 0.05,
                 .largest = 0.5,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   RotorChange c = some_rotor(f, k, 0);
                   c.thrust_scale = 1 - a;
                   f.world.rotors.push_back(c);
                 }});
  out.push_back({.id = "rotor_thrust_scale",
                 .stage = "wrench",
                 .realisation = "one propeller with a chipped blade: weaker, less drag, shaking",
                 .smallest = 5e-4,
                 .typical = 0.05,
                 .largest = 0.4,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       RotorChange c = some_rotor(f, k, 0);
                       c.thrust_scale = 1 - a;
                       c.exponent = 2 - 0.15 * a;
                       c.drag_torque_scale = 1 - 0.2 * a;
                       f.world.rotors.push_back(c);
                       f.world.sensors.vibration += 6 * a;
                       f.world.sensors.vibration_rotor = c.rotor;
                     },
                 .along = {"vibration"}});
  out.push_back(
      {.id = "reverse_thrust_asymmetry",
       .stage = "wrench",
       .realisation = "less thrust backwards",
       .law = true,
       .smallest = 1e-3,
       .typical = 0.2,
       .largest = 0.6,
       .possible = turns_back,
       .apply = [](FamilyFlight& f, double a,
                   const Shape&) { each_rotor(f, [a](RotorChange& c, int) { c.reverse_scale = 1 - a; }); },
       .parameters = [](const FamilyFlight&, double a,
                        const Shape&) { return Parameters{scalar("change", -a)}; }});
  out.push_back({.id = "reverse_thrust_asymmetry",
                 .stage = "wrench",
                 .realisation = "cambered propellers: each loses another share backwards, with more drag",
                 .smallest = 1e-3,
                 .typical = 0.2,
                 .largest = 0.5,
                 .possible = turns_back,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   each_rotor(f, [&](RotorChange& c, int i) {
                     c.reverse_scale = 1 - a * (1 + 0.2 * std::sin(1.7 * i + 6 * k.u[0]));
                   });
                 }});
  out.push_back({.id = "thrust_curve",
                 .stage = "wrench",
                 .realisation = "another exponent of thrust over speed",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.6,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   each_rotor(f, [&](RotorChange& c, int) { c.exponent = 2 + a * k.sign(0); });
                 }});
  out.push_back({.id = "thrust_curve",
                 .stage = "wrench",
                 .realisation = "a share of thrust that goes with the speed",
                 .law = true,
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.7,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [a](RotorChange& c, int) { c.linear_share = a; });
                 }});
  out.push_back({.id = "drag_torque_scale",
                 .stage = "wrench",
                 .realisation = "propellers of another drag",
                 .law = true,
                 .smallest = 1e-3,
                 .typical = 0.2,
                 .largest = 0.55,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       each_rotor(f, [&](RotorChange& c, int) { c.drag_torque_scale = 1 + a * k.sign(0); });
                     },
                 .parameters = [](const FamilyFlight&, double a,
                                  const Shape& k) { return Parameters{scalar("scale", a * k.sign(0))}; }});
  out.push_back({.id = "drag_torque_scale",
                 .stage = "wrench",
                 .realisation = "drag that changes with the Reynolds number",
                 .smallest = 1e-3,
                 .typical = 0.3,
                 .largest = 0.9,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [a](RotorChange& c, int) {
                     c.drag_exponent = -a;
                     c.drag_torque_scale = 1 + 0.8 * a;
                   });
                 }});
  out.push_back({.id = "rotor_inertia",
                 .stage = "wrench",
                 .realisation = "spinning parts with inertia",
                 .law = true,
                 .smallest = 1e-5,
                 .typical = 2e-3,
                 .largest = 0.02,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       each_rotor(
                           f, [&](RotorChange& c, int) { c.inertia = a * f.vehicle.nominal.inertia(2, 2); });
                     },
                 .parameters =
                     [](const FamilyFlight& f, double a, const Shape&) {
                       return Parameters{scalar("inertia", a * f.vehicle.nominal.inertia(2, 2))};
                     }});
  out.push_back({.id = "rotor_inertia",
                 .stage = "wrench",
                 .realisation = "bells and spinners of two makes",
                 .smallest = 1e-5,
                 .typical = 2e-3,
                 .largest = 0.02,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [&](RotorChange& c, int i) {
                     c.inertia = a * f.vehicle.nominal.inertia(2, 2) * (i % 3 == 0 ? 1.5 : 0.75);
                   });
                 }});
}

}  // namespace omniflight::proof
