// Cables and ropes of links.
#include "hidden.hpp"

namespace omniflight::proof {

namespace {

/// A cable that hangs to the floor from every height of the flight, with some left on it.
Cable cable(const FamilyFlight& f, double share, const Shape& k, int links) {
  Cable c;
  double high = 0;
  for (double t = 0; t < f.path.duration; t += 0.2) high = std::max(high, f.path.position[2].at(t).value);
  c.length = std::min(10.0, (high - f.world.floor_z) * k.between(0, 1.15, 1.35));
  c.linear_density = share * mass(f) / (start_height(f) - f.world.floor_z);
  c.links = links;
  c.diameter = std::clamp(0.05 * arm(f), 0.001, 0.008);
  c.attachment_B = Vec3(0, 0, -0.35 * arm(f));
  // the joints' own damping is felt in proportion to what hangs from them
  c.damping = 2e-3 * c.linear_density * std::pow(c.length / links, 2) * 100;
  return c;
}

}  // namespace

void hide_cables(std::vector<Hidden>& out) {
  const auto density = [](const FamilyFlight& f, double a) {
    return a * mass(f) / (start_height(f) - f.world.floor_z);
  };
  out.push_back(
      {.id = "hung_cable",
       .stage = "wrench",
       .realisation = "links with floor contact",
       .slow = true,
       .smallest = 1e-3,
       .typical = 0.06,
       .largest = 0.25,
       .possible = high,
       .apply = [](FamilyFlight& f, double a, const Shape& k) { f.world.cable = cable(f, a, k, 12); },
       .parameters = [density](const FamilyFlight& f, double a,
                               const Shape&) { return Parameters{scalar("linear_density", density(f, a))}; },
       .along = {"attachment_torque", "slung_load"}});
  out.push_back(
      {.id = "hung_cable",
       .stage = "wrench",
       .realisation = "a stiff lead in few links, off the middle",
       .slow = true,
       .smallest = 1e-3,
       .typical = 0.06,
       .largest = 0.25,
       .possible = high,
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             f.world.cable = cable(f, a, k, 8);
             f.world.cable->attachment_B += 0.2 * arm(f) * k.direction(2, true);
             f.world.cable->bending_stiffness =
                 0.02 * f.world.cable->linear_density * kGravity * std::pow(f.world.cable->length / 8, 3);
           },
       .parameters = [density](const FamilyFlight& f, double a,
                               const Shape&) { return Parameters{scalar("linear_density", density(f, a))}; },
       .along = {"attachment_torque", "com_offset", "slung_load"}});
  const auto rope = [](const FamilyFlight& f, double a, const Shape& k, const Vec3& anchor, int links) {
    OverheadRope r;
    r.anchor_W = anchor;
    r.attachment_B = Vec3(0, 0, 0.35 * arm(f));
    double farthest = 0;
    for (double t = 0; t < f.path.duration; t += 0.2)
      farthest = std::max(farthest, (f.path.at(t).p_WB - anchor).norm());
    r.length = std::min(20.0, k.between(0, 1.08, 1.2) * farthest + 0.3);
    r.links = links;
    r.linear_density = a * mass(f) / r.length;
    r.damping = 0.2 * r.linear_density * std::pow(r.length / links, 2);
    return r;
  };
  const auto along_rope = [rope](int links, bool side) {
    return [rope, links, side](FamilyFlight& f, double a, const Shape& k) {
      const Vec3 above(0, 0, start_height(f) + 1.2 * f.vehicle.reach + 0.8);
      const Vec3 beside = (1.8 * f.vehicle.reach + 0.5) * k.direction(1, true) +
                          Vec3(0, 0, start_height(f) - 0.2 * f.vehicle.reach);
      f.world.overhead_rope = rope(f, a, k, side ? beside : above, links);
    };
  };
  out.push_back({.id = "overhead_rope",
                 .stage = "wrench",
                 .realisation = "links between vehicle and ceiling",
                 .slow = true,
                 .smallest = 1e-3,
                 .typical = 0.06,
                 .largest = 0.35,
                 .apply = along_rope(12, false),
                 .along = {"attachment_torque"}});
  out.push_back({.id = "overhead_rope",
                 .stage = "wrench",
                 .realisation = "a chain of few heavy links to the ceiling",
                 .slow = true,
                 .smallest = 1e-3,
                 .typical = 0.06,
                 .largest = 0.35,
                 .apply = along_rope(6, false),
                 .along = {"attachment_torque"}});
  out.push_back({.id = "catenary",
                 .stage = "wrench",
                 .realisation = "links to a point at the side",
                 .combines = false,
                 .slow = true,
                 .smallest = 1e-3,
                 .typical = 0.06,
                 .largest = 0.35,
                 .apply = along_rope(12, true),
                 .along = {"attachment_torque"}});
  out.push_back({.id = "catenary",
                 .stage = "wrench",
                 .realisation = "a heavy lead of few links to the side",
                 .combines = false,
                 .slow = true,
                 .smallest = 1e-3,
                 .typical = 0.06,
                 .largest = 0.35,
                 .apply = along_rope(6, true),
                 .along = {"attachment_torque"}});
  out.push_back({.id = "cable_drag",
                 .stage = "wrench",
                 .realisation = "a light ribbon below, in still air",
                 .combines = false,
                 .smallest = 0.01,
                 .typical = 1,
                 .largest = 30,
                 .possible = [](const FamilyVehicle&, const Coordinates& c) { return c.manoeuvre != "T1"; },
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       Airframe body;
                       body.drag_area_B = a * 0.3 * arm(f) * arm(f) * Vec3(1, 1, 0.05);
                       body.center_B = Vec3(0, 0, -k.between(0, 1.5, 3) * arm(f));
                       f.world.airframe = body;
                     },
                 .along = {"parasitic_drag"}});
  out.push_back(
      {.id = "cable_drag",
       .stage = "wrench",
       .realisation = "links of a thick light cable in the air",
       .combines = false,
       .slow = true,
       .smallest = 0.01,
       .typical = 1,
       .largest = 10,
       .possible = [](const FamilyVehicle& v,
                      const Coordinates& c) { return c.manoeuvre != "T1" && v.nominal.mass > 0.5 && !c.low; },
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             f.world.cable = cable(f, 0.004, k, 8);
             f.world.cable->diameter = 0.03;
             f.world.cable->drag_coefficient = std::min(5.0, 1.2 * a);
           },
       .along = {"hung_cable", "parasitic_drag", "attachment_torque", "slung_load"}});
}

}  // namespace omniflight::proof
