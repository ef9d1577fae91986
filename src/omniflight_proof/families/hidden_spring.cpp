// Springs, friction, contact.
#include "hidden.hpp"

namespace omniflight::proof {

void hide_springs(std::vector<Hidden>& out) {
  out.push_back({.id = "taut_rope",
                 .stage = "wrench",
                 .realisation = "a rope that comes taut at the edge of the flight",
                 .law = true,
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 1,
                 .largest = 60,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   Spring s;
                   s.anchor_W = start_height(f) * Vec3::UnitZ() - 2 * f.vehicle.reach * k.direction(0, true);
                   double farthest = 0;
                   for (double t = f.lead; t < f.path.duration; t += 0.1)
                     farthest = std::max(farthest, (f.path.at(t).p_WB - s.anchor_W).norm());
                   s.rest_length = std::max(0.3, farthest - 0.25 * f.vehicle.reach);
                   s.stiffness = a * weight(f) / f.vehicle.reach;
                   s.damping = 0.02 * s.stiffness;
                   f.world.springs.push_back(s);
                 }});
  out.push_back({.id = "taut_rope",
                 .stage = "wrench",
                 .realisation = "a bungee that stiffens as it is pulled out",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 1,
                 .largest = 40,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   Spring s;
                   s.anchor_W = start_height(f) * Vec3::UnitZ() - 1.5 * f.vehicle.reach * k.direction(0);
                   double farthest = 0;
                   for (double t = f.lead; t < f.path.duration; t += 0.1)
                     farthest = std::max(farthest, (f.path.at(t).p_WB - s.anchor_W).norm());
                   s.rest_length = std::max(0.2, farthest - 0.4 * f.vehicle.reach);
                   s.stiffness = 0.5 * a * weight(f) / f.vehicle.reach;
                   s.hardening = 3 / f.vehicle.reach;
                   f.world.springs.push_back(s);
                 }});
  out.push_back({.id = "lateral_stiffness",
                 .stage = "wrench",
                 .realisation = "a long tight rope overhead: a spring to the side",
                 .law = true,
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 1,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   // two springs along the horizontal axes through far points: stiff to the side, not to
                   // height
                   for (const double angle : {0.0, 0.5 * kPi})
                     for (const double end : {-1.0, 1.0}) {
                       Spring s;
                       const double turn = angle + kPi * k.u[0];
                       s.anchor_W = 40 * end * Vec3(std::cos(turn), std::sin(turn), 0) +
                                    start_height(f) * Vec3::UnitZ() +
                                    0.2 * f.vehicle.reach * k.direction(1, true);
                       s.stiffness = 0.5 * a * weight(f) / f.vehicle.reach;
                       s.rest_length = 39.9;
                       s.rope = false;
                       f.world.springs.push_back(s);
                     }
                 }});
  out.push_back({.id = "lateral_stiffness",
                 .stage = "wrench",
                 .realisation = "a tight elastic overhead",
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 0.6,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       Spring s;  // tension over length to the side; its pull upwards is there as well
                       s.anchor_W = Vec3(0, 0, start_height(f) + 2.5 * f.vehicle.reach) +
                                    0.2 * f.vehicle.reach * k.direction(1, true);
                       s.rest_length = 0.1 * f.vehicle.reach;
                       s.stiffness = a * weight(f) / (2.5 * f.vehicle.reach);
                       f.world.springs.push_back(s);
                     },
                 .along = {"constant_pull", "payload_mass", "overhead_rope", "taut_rope"}});
  const auto law = [](Law::Kind kind, double gain, const Vec3& axis, double scale) {
    Law l;
    l.kind = kind;
    l.gain = gain;
    l.axis = axis;
    l.scale = scale;
    return l;
  };
  out.push_back(
      {.id = "cable_torsion",
       .stage = "wrench",
       .realisation = "a lead that is twisted",
       .law = true,
       .smallest = 1e-4,
       .typical = 0.01,
       .largest = 0.15,
       .possible = [](const FamilyVehicle&,
                      const Coordinates& c) { return c.manoeuvre != "T1" && c.manoeuvre != "T2"; },
       .apply =
           [law](FamilyFlight& f, double a, const Shape& k) {
             Law l = law(Law::Kind::torsion, a * weight(f) * arm(f), Vec3::UnitZ(), 1);
             l.center_W.x() = k.between(0, -0.6, 0.6);
             f.world.laws.push_back(l);
           },
       .parameters = [](const FamilyFlight& f, double a,
                        const Shape&) { return Parameters{scalar("torsion", a * weight(f) * arm(f))}; }});
  out.push_back({.id = "cable_torsion",
                 .stage = "wrench",
                 .realisation = "a bundle that stiffens with the twist",
                 .smallest = 1e-4,
                 .typical = 0.01,
                 .largest = 0.12,
                 .possible = [](const FamilyVehicle&,
                                const Coordinates& c) { return c.manoeuvre != "T1" && c.manoeuvre != "T2"; },
                 .apply =
                     [law](FamilyFlight& f, double a, const Shape& k) {
                       f.world.laws.push_back(law(Law::Kind::torsion_cubic, 0.5 * a * weight(f) * arm(f),
                                                  Vec3::UnitZ(), k.between(0, 0.4, 0.8)));
                     }});
  out.push_back({.id = "guide_friction",
                 .stage = "wrench",
                 .realisation = "rubbing in all directions",
                 .law = true,
                 .smallest = 2e-4,
                 .typical = 0.02,
                 .largest = 0.15,
                 .apply = [law](FamilyFlight& f, double a, const Shape&) {
                   f.world.laws.push_back(law(Law::Kind::friction, a * weight(f), Vec3::UnitZ(), 0.03));
                 }});
  out.push_back({.id = "guide_friction",
                 .stage = "wrench",
                 .realisation = "a guide rope that rubs along one direction",
                 .smallest = 2e-4,
                 .typical = 0.02,
                 .largest = 0.15,
                 .apply = [law](FamilyFlight& f, double a, const Shape& k) {
                   const Vec3 along = (Vec3::UnitZ() + 0.4 * k.direction(0, true)).normalized();
                   f.world.laws.push_back(
                       law(Law::Kind::rail, 1.3 * a * weight(f), along, k.between(2, 0.06, 0.12)));
                 }});
  const auto at_rest = [](const FamilyVehicle&, const Coordinates& c) {
    return c.start == "rest" && c.manoeuvre != "T1";
  };
  out.push_back({.id = "hanging_start",
                 .stage = "wrench",
                 .realisation = "a rope still carries it at first",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.3,
                 .largest = 0.9,
                 .possible = at_rest,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   Pull p;
                   p.force_W = a * weight(f) * Vec3::UnitZ();
                   p.until = f.lead + 1 + k.between(0, 3, 7);
                   p.fades = k.between(1, 0.8, 2);
                   f.world.pulls.push_back(p);
                 }});
  out.push_back({.id = "hanging_start",
                 .stage = "wrench",
                 .realisation = "an elastic from above, slack once it has climbed",
                 .law = true,
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.3,
                 .largest = 0.9,
                 .possible = at_rest,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       Spring s;
                       const double slack = k.between(0, 0.06, 0.15) * f.vehicle.reach;
                       s.anchor_W = Vec3(0, 0, start_height(f) + 2 * f.vehicle.reach);
                       s.rest_length = 2 * f.vehicle.reach - slack;
                       s.stiffness = a * weight(f) / slack;
                       s.damping = 0.05 * s.stiffness;
                       f.world.springs.push_back(s);
                     },
                 .along = {"taut_rope"}});
}

}  // namespace omniflight::proof
