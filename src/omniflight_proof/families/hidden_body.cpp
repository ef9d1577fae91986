// Mass, balance, geometry.
#include "hidden.hpp"

namespace omniflight::proof {

void hide_rigid_body(std::vector<Hidden>& out) {
  // amplitudes: of the mass, of the arm, of the inertia
  out.push_back(
      {.id = "payload_mass",
       .stage = "wrench",
       .realisation = "a ball welded to the body",
       .law = true,
       .smallest = 2e-4,
       .typical = 0.05,
       .largest = 0.35,
       .apply = [](FamilyFlight& f, double a, const Shape&) { f.world.body.payload += a * mass(f); },
       .parameters = [](const FamilyFlight& f, double a,
                        const Shape&) { return Parameters{scalar("mass", a * mass(f))}; }});
  out.push_back({.id = "payload_mass",
                 .stage = "wrench",
                 .realisation = "a load on a soft mount inside",
                 .slow = true,
                 .smallest = 2e-4,
                 .typical = 0.05,
                 .largest = 0.25,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       f.world.body.payload += a * mass(f);
                       f.world.body.sloshing_mass = a * mass(f);
                       f.world.body.sloshing_frequency = k.between(0, 12, 20);
                       f.world.body.sloshing_damping_ratio = k.between(1, 0.2, 0.5);
                     },
                 .parameters = [](const FamilyFlight& f, double a,
                                  const Shape&) { return Parameters{scalar("mass", a * mass(f))}; }});
  out.push_back({.id = "com_offset",
                 .stage = "wrench",
                 .realisation = "the body's mass elsewhere",
                 .law = true,
                 .smallest = 1e-4,
                 .typical = 0.02,
                 .largest = 0.25,
                 .apply = [](FamilyFlight& f, double a,
                             const Shape& k) { f.world.body.com_shift_B += a * arm(f) * k.direction(0); },
                 .parameters =
                     [](const FamilyFlight& f, double a, const Shape& k) {
                       return three({"x", "y", "z"}, a * arm(f) * k.direction(0));
                     }});
  out.push_back({.id = "com_offset",
                 .stage = "wrench",
                 .realisation = "a battery of a quarter of the mass on its rail",
                 .smallest = 1e-4,
                 .typical = 0.02,
                 .largest = 0.2,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       const Vec3 along = k.direction(0, true);
                       f.world.body.com_shift_B += a * arm(f) * along;
                       // the battery moved four times as far; its moments of inertia with it
                       const Vec3 moved = 4 * a * arm(f) * along;
                       const Vec3 added =
                           0.25 * mass(f) * (Vec3::Constant(moved.squaredNorm()) - moved.cwiseAbs2());
                       f.world.body.inertia_scale +=
                           added.cwiseQuotient(f.vehicle.nominal.inertia.diagonal());
                     },
                 .parameters =
                     [](const FamilyFlight& f, double a, const Shape& k) {
                       return three({"x", "y", "z"}, a * arm(f) * k.direction(0, true));
                     },
                 .along = {"inertia_error"}});
  out.push_back({.id = "inertia_error",
                 .stage = "wrench",
                 .realisation = "other moments of inertia",
                 .law = true,
                 .smallest = 1e-3,
                 .typical = 0.2,
                 .largest = 0.45,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       f.world.body.inertia_scale =
                           Vec3::Constant(1 + a * k.sign(0)) + 0.12 * a * k.direction(1);
                     },
                 .parameters =
                     [](const FamilyFlight& f, double a, const Shape& k) {
                       return three({"xx", "yy", "zz"},
                                    f.vehicle.nominal.inertia.diagonal().cwiseProduct(
                                        Vec3(Vec3::Constant(a * k.sign(0)) + 0.12 * a * k.direction(1))));
                     }});
  out.push_back({.id = "inertia_error",
                 .stage = "wrench",
                 .realisation = "axes of inertia turned, and one larger",
                 .smallest = 1e-3,
                 .typical = 0.2,
                 .largest = 0.4,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   f.world.body.inertia_turn_B = 0.5 * a * k.direction(1);
                   f.world.body.inertia_scale[k.whole(0, 0, 1)] += a;
                   f.world.body.inertia_scale[2] += 0.6 * a;
                 }});
  out.push_back({.id = "rotor_axis_misalignment",
                 .stage = "wrench",
                 .realisation = "one rotor mounted askew",
                 .law = true,
                 .smallest = 5e-4,
                 .typical = 0.03,
                 .largest = 0.25,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   RotorChange c = some_rotor(f, k, 0);
                   c.axis_tilt_B = a * k.direction(1, true);
                   f.world.rotors.push_back(c);
                 }});
  out.push_back({.id = "rotor_axis_misalignment",
                 .stage = "wrench",
                 .realisation = "a motor mount that bends with thrust",
                 .smallest = 5e-4,
                 .typical = 0.03,
                 .largest = 0.25,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   RotorChange c = some_rotor(f, k, 0);
                   c.lean_B = a * k.direction(1, true) / (weight(f) / f.vehicle.nominal.rotor_count());
                   f.world.rotors.push_back(c);
                 }});
  out.push_back({.id = "rotor_position_error",
                 .stage = "wrench",
                 .realisation = "one rotor mounted elsewhere",
                 .law = true,
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 0.3,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   RotorChange c = some_rotor(f, k, 0);
                   c.shift_B = a * arm(f) * k.direction(1, true);
                   f.world.rotors.push_back(c);
                 }});
  out.push_back({.id = "rotor_position_error",
                 .stage = "wrench",
                 .realisation = "an arm of another length, bent down",
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 0.25,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   RotorChange c = some_rotor(f, k, 0);
                   const Vec3& p = f.vehicle.nominal.rotors[static_cast<std::size_t>(c.rotor - 1)].p_BR;
                   c.shift_B = a * k.sign(1) * p - 0.3 * a * p.norm() * Vec3::UnitZ();
                   f.world.rotors.push_back(c);
                 }});
  out.push_back(
      {.id = "tilt_offset",
       .stage = "wrench",
       .realisation = "linkage of the tilt mounted askew",
       .law = true,
       .smallest = 5e-4,
       .typical = 0.02,
       .largest = 0.15,
       .possible = tilts,
       .apply = [](FamilyFlight& f, double a, const Shape& k) { f.world.tilt.offset += a * k.sign(0); },
       .parameters = [](const FamilyFlight&, double a,
                        const Shape& k) { return Parameters{scalar("offset", a * k.sign(0))}; }});
  out.push_back({.id = "tilt_offset",
                 .stage = "wrench",
                 .realisation = "every rotor's own share of the offset",
                 .smallest = 5e-4,
                 .typical = 0.02,
                 .largest = 0.12,
                 .possible = tilts,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   each_rotor(f, [&](RotorChange& c, int i) {
                     const auto& r = f.vehicle.nominal.rotors[static_cast<std::size_t>(i)];
                     c.axis_tilt_B = a * k.sign(0) * (0.75 + 0.5 * ((i * 5) % 8) / 7.0) * r.tilt_axis_B;
                   });
                 }});
}

}  // namespace omniflight::proof
