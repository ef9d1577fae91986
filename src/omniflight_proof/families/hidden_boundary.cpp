// Floor, ceiling, walls, slipstreams of rotors and of other vehicles.
#include "hidden.hpp"

namespace omniflight::proof {

void hide_boundaries(std::vector<Hidden>& out) {
  out.push_back({.id = "ground_effect",
                 .stage = "wrench",
                 .realisation = "image of the slipstream in the floor",
                 .combines = false,
                 .smallest = 0.05,
                 .typical = 2,
                 .largest = 8,
                 .possible = low,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   f.world.planes.emplace();
                   f.world.planes->floor = a;
                 }});
  out.push_back({.id = "ground_effect",
                 .stage = "wrench",
                 .realisation = "a cushion that fades with height",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.6,
                 .possible = low,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   Law l;
                   l.kind = Law::Kind::cushion;
                   l.gain = a * weight(f);
                   l.axis = Vec3::UnitZ();
                   l.center_W = Vec3(0, 0, f.world.floor_z);
                   l.scale = k.between(0, 0.7, 1.2) * 2 * f.vehicle.nominal.rotors[0].radius + 0.05;
                   f.world.laws.push_back(l);
                 }});
  out.push_back({.id = "ceiling_effect",
                 .stage = "wrench",
                 .realisation = "image of the slipstream in the ceiling",
                 .combines = false,
                 .smallest = 0.05,
                 .typical = 2,
                 .largest = 8,
                 .possible = climbs,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   f.world.planes.emplace();
                   f.world.planes->ceiling = a;
                   f.world.planes->ceiling_z = highest(f) + 1.0 * f.vehicle.nominal.rotors[0].radius + 0.08;
                 }});
  out.push_back({.id = "ceiling_effect",
                 .stage = "wrench",
                 .realisation = "suction that grows towards the ceiling",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.5,
                 .possible = climbs,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   Law l;  // along -z from the ceiling, pulling upwards
                   l.kind = Law::Kind::cushion;
                   l.gain = -a * weight(f);
                   l.axis = -Vec3::UnitZ();
                   l.center_W = Vec3(0, 0, highest(f) + 0.1);
                   l.scale = k.between(0, 1.0, 1.8) * 2 * f.vehicle.nominal.rotors[0].radius + 0.05;
                   f.world.laws.push_back(l);
                 }});
  const auto wall = [](FamilyFlight& f, double a, const Shape& k, double width) {
    const Vec3 away = k.direction(0, true);
    double nearest = 1e300;
    for (double t = f.lead; t < f.path.duration; t += 0.2)
      nearest = std::min(nearest, f.path.at(t).p_WB.dot(away));
    Law l;
    l.kind = Law::Kind::cushion;
    l.axis = away;
    l.center_W = (nearest - 0.2) * away;
    l.gain = a * weight(f);
    l.scale = width;
    return l;
  };
  out.push_back({.id = "wall_effect",
                 .stage = "wrench",
                 .realisation = "a force from the wall that fades with distance",
                 .law = true,
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 0.3,
                 .possible = moves,
                 .apply = [wall](FamilyFlight& f, double a, const Shape& k) {
                   f.world.laws.push_back(wall(f, a, k, k.between(2, 0.15, 0.4)));
                 }});
  out.push_back({.id = "wall_effect",
                 .stage = "wrench",
                 .realisation = "a net: force within reach, and friction in it",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.05,
                 .largest = 0.3,
                 .possible = moves,
                 .apply = [wall](FamilyFlight& f, double a, const Shape& k) {
                   Law l = wall(f, a, k, 0.3);
                   l.kind = Law::Kind::well;
                   l.scale = f.vehicle.reach;
                   l.center_W = l.center_W - 0.3 * l.axis + f.path.position[2].start * Vec3::UnitZ();
                   f.world.laws.push_back(l);
                 }});
  out.push_back(
      {.id = "downwash_interference",
       .stage = "wrench",
       .realisation = "contracting and spreading jets",
       .combines = false,
       .smallest = 2e-3,
       .typical = 0.3,
       .largest = 1.2,
       .possible = [](const FamilyVehicle& v, const Coordinates&) { return v.nominal.rotors[0].tilts; },
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             f.world.jets = Jets{.strength = a, .spread = k.between(0, 0.04, 0.1)};
           }});
  out.push_back(
      {.id = "downwash_interference",
       .stage = "wrench",
       .realisation = "jets on blades with slow inflow, and on the core",
       .combines = false,
       .smallest = 2e-3,
       .typical = 0.3,
       .largest = 1.2,
       .possible = [](const FamilyVehicle& v, const Coordinates&) { return v.nominal.rotors[0].tilts; },
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             f.world.jets = Jets{.strength = a, .spread = k.between(0, 0.08, 0.16), .body_drag = 0.002};
           }});
  const auto neighbour = [](const FamilyFlight& f, double a) {
    Neighbour n;
    n.thrust = a * weight(f);
    n.radius = std::max(0.05, 0.8 * arm(f));
    n.p_W = f.path.at(f.lead + 1).p_WB;
    n.p_W.z() = highest(f) + 0.5 + 1.5 * f.vehicle.reach;
    return n;
  };
  out.push_back({.id = "neighbour_downwash",
                 .stage = "wrench",
                 .realisation = "another vehicle hovers above",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 1,
                 .largest = 8,
                 .possible = moves,
                 .apply =
                     [neighbour](FamilyFlight& f, double a, const Shape& k) {
                       Neighbour n = neighbour(f, a);
                       n.p_W += 0.3 * f.vehicle.reach * k.direction(0, true);
                       f.world.neighbours.push_back(n);
                       airframe(f).drag_area_B += frontal(f) * Vec3(0.05, 0.05, 0.1);
                     },
                 .along = {"parasitic_drag"}});
  out.push_back({.id = "neighbour_downwash",
                 .stage = "wrench",
                 .realisation = "another vehicle comes and goes above",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 1,
                 .largest = 8,
                 .apply =
                     [neighbour](FamilyFlight& f, double a, const Shape& k) {
                       Neighbour n = neighbour(f, a);
                       const double length = f.path.duration - f.lead;
                       n.v_W = 0.08 * f.vehicle.reach * k.direction(0, true);
                       n.p_W -= (f.lead + 0.5 * length) * n.v_W;
                       n.appears = f.lead + length * k.between(2, 0.1, 0.3);
                       n.leaves = f.lead + length * k.between(3, 0.6, 0.9);
                       f.world.neighbours.push_back(n);
                       airframe(f).drag_area_B += frontal(f) * Vec3(0.05, 0.05, 0.1);
                     },
                 .along = {"parasitic_drag"}});
}

}  // namespace omniflight::proof
