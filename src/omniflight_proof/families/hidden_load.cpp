// Loads and pulls.
#include "hidden.hpp"

namespace omniflight::proof {

void hide_loads(std::vector<Hidden>& out) {
  const auto ball = [](const FamilyFlight& f, double a, const Shape& k, int links) {
    SlungBall b;
    b.mass = a * mass(f);
    b.length = std::min(0.8 * (start_height(f) - 0.5 * f.vehicle.reach), k.between(0, 1.5, 5) * arm(f) + 0.1);
    b.radius = std::clamp(0.1 * arm(f), 0.003, 0.03);
    b.attachment_B = Vec3(0, 0, -0.15 * arm(f));
    b.damping = 0.02 * b.mass * b.length * b.length;
    b.links = links;
    return b;
  };
  const auto length = [ball](const FamilyFlight& f, double a, const Shape& k) {
    return Parameters{scalar("mass", a * mass(f)), scalar("length", ball(f, a, k, 1).length)};
  };
  out.push_back(
      {.id = "slung_load",
       .stage = "wrench",
       .realisation = "a ball on a swivelling rod",
       .law = true,
       .slow = true,
       .smallest = 5e-4,
       .typical = 0.05,
       .largest = 0.3,
       .possible = high,
       .apply = [ball](FamilyFlight& f, double a, const Shape& k) { f.world.slung_ball = ball(f, a, k, 1); },
       .parameters = length,
       .along = {"attachment_torque"}});
  out.push_back(
      {.id = "slung_load",
       .stage = "wrench",
       .realisation = "a ball on a rope of five pieces",
       .slow = true,
       .smallest = 5e-4,
       .typical = 0.05,
       .largest = 0.3,
       .possible = high,
       .apply = [ball](FamilyFlight& f, double a, const Shape& k) { f.world.slung_ball = ball(f, a, k, 5); },
       .parameters = length,
       .along = {"attachment_torque"}});
  out.push_back({.id = "constant_pull",
                 .stage = "wrench",
                 .realisation = "a constant-force spring far away",
                 .law = true,
                 .smallest = 2e-4,
                 .typical = 0.03,
                 .largest = 0.3,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       Pull p;
                       p.force_W = a * weight(f) * k.direction(0);
                       f.world.pulls.push_back(p);
                     },
                 .parameters =
                     [](const FamilyFlight& f, double a, const Shape& k) {
                       return three({"x", "y", "z"}, a * weight(f) * k.direction(0));
                     }});
  out.push_back({.id = "constant_pull",
                 .stage = "wrench",
                 .realisation = "a long elastic, stretched far",
                 .smallest = 2e-4,
                 .typical = 0.03,
                 .largest = 0.3,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       Spring s;  // 12 m of it pulled out: 1 m of flight changes the pull by a twelfth
                       s.anchor_W = start_height(f) * Vec3::UnitZ() + 20 * k.direction(0);
                       s.rest_length = 8;
                       s.stiffness = a * weight(f) / 12;
                       f.world.springs.push_back(s);
                     },
                 .parameters =
                     [](const FamilyFlight& f, double a, const Shape& k) {
                       return three({"x", "y", "z"}, a * weight(f) * k.direction(0));
                     },
                 .along = {"lateral_stiffness"}});
  // a pull beside the middle is always two: what hangs, and its torque
  out.push_back({.id = "attachment_torque",
                 .stage = "wrench",
                 .realisation = "a constant pull far off the middle",
                 .combines = false,
                 .smallest = 2e-4,
                 .typical = 0.02,
                 .largest = 0.25,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       Pull p;
                       p.force_W = a * weight(f) * -Vec3::UnitZ();
                       p.attachment_B = arm(f) * Vec3(k.between(0, -0.6, 0.6), k.between(1, -0.6, 0.6), -0.8);
                       f.world.pulls.push_back(p);
                     },
                 .along = {"constant_pull", "com_offset"}});
  out.push_back(
      {.id = "attachment_torque",
       .stage = "wrench",
       .realisation = "an elastic from above, tied to an arm",
       .combines = false,
       .smallest = 2e-4,
       .typical = 0.02,
       .largest = 0.25,
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             Spring s;
             s.anchor_W = (start_height(f) + 12) * Vec3::UnitZ();
             s.rest_length = 4;
             s.stiffness = a * weight(f) / 8;
             s.attachment_B = 0.7 * arm(f) * k.direction(0, true);
             f.world.springs.push_back(s);
           },
       .along = {"constant_pull", "com_offset", "lateral_stiffness", "thrust_scale", "payload_mass"}});
}

}  // namespace omniflight::proof
