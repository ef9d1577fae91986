// Drag, inflow, wind.
#include "hidden.hpp"

namespace omniflight::proof {

namespace {

void drag(std::vector<Hidden>& out) {
  // amplitude of rotor drag: of weight / (rotors * hover speed * 1 m/s)
  const auto unit = [](const FamilyFlight& f) {
    return weight(f) / f.vehicle.nominal.rotor_count() / hover_speed(f);
  };
  out.push_back(
      {.id = "rotor_drag",
       .stage = "wrench",
       .realisation = "force across the axis by a coefficient",
       .law = true,
       .smallest = 1e-4,
       .typical = 0.02,
       .largest = 0.12,
       .possible = moves,
       .apply = [unit](FamilyFlight& f, double a, const Shape&) { rotor_air(f).drag += a * unit(f); },
       .parameters = [unit](const FamilyFlight& f, double a,
                            const Shape&) { return Parameters{scalar("coefficient", a * unit(f))}; }});
  out.push_back({.id = "rotor_drag",
                 .stage = "wrench",
                 .realisation = "blade elements moved edgewise",
                 .smallest = 0.02,
                 .typical = 0.6,
                 .largest = 3,
                 .possible = moves,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       Blades b;
                       b.solidity_slope = std::clamp(a, 0.05, 3.0);
                       b.flapping = std::min(2.0, 0.8 * a);
                       f.world.blades = b;
                     },
                 .along = {"axial_inflow", "blade_flapping", "drag_torque_scale"}});
  out.push_back({.id = "blade_flapping",
                 .stage = "wrench",
                 .realisation = "hub moment by a coefficient",
                 .law = true,
                 .smallest = 1e-4,
                 .typical = 0.02,
                 .largest = 0.15,
                 .possible = moves,
                 .apply = [unit](FamilyFlight& f, double a,
                                 const Shape&) { rotor_air(f).flapping += a * unit(f) * arm(f); },
                 .parameters =
                     [unit](const FamilyFlight& f, double a, const Shape&) {
                       return Parameters{scalar("coefficient", a * unit(f) * arm(f))};
                     }});
  out.push_back({.id = "blade_flapping",
                 .stage = "wrench",
                 .realisation = "blades that flap on a stiff hub",
                 .smallest = 0.01,
                 .typical = 0.3,
                 .largest = 2,
                 .possible = moves,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       Blades b;
                       b.solidity_slope = 0.5;
                       b.flapping = 0.05;  // the disc hardly tilts: what is felt is the moment
                       b.hub_stiffness =
                           std::min(50.0, 20 * a * weight(f) * arm(f) / f.vehicle.nominal.rotor_count());
                       f.world.blades = b;
                     },
                 .along = {"rotor_drag", "axial_inflow", "drag_torque_scale"}});
  out.push_back({.id = "axial_inflow",
                 .stage = "wrench",
                 .realisation = "blade elements moved along the axis",
                 .smallest = 0.05,
                 .typical = 0.6,
                 .largest = 3,
                 .possible = climbs,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       Blades b;
                       b.solidity_slope = std::clamp(a, 0.05, 3.0);
                       b.edgewise = false;
                       f.world.blades = b;
                     },
                 .along = {"drag_torque_scale"}});
  out.push_back({.id = "axial_inflow",
                 .stage = "wrench",
                 .realisation = "broad slow blades whose inflow is late",
                 .smallest = 0.05,
                 .typical = 0.6,
                 .largest = 3,
                 .possible = climbs,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       Blades b;
                       b.solidity_slope = std::clamp(a, 0.05, 3.0);
                       b.edgewise = false;
                       b.inflow_time = k.between(0, 0.01, 0.03);
                       f.world.blades = b;
                     },
                 .along = {"dynamic_inflow", "drag_torque_scale"}});
  out.push_back({.id = "dynamic_inflow",
                 .stage = "wrench",
                 .realisation = "thrust overshoots until the air follows",
                 .law = true,
                 .smallest = 1e-3,
                 .typical = 0.02,
                 .largest = 0.12,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   const double lead = k.between(0, 0.3, 0.8);
                   each_rotor(f, [&](RotorChange& c, int) {
                     c.thrust_lag = a;
                     c.thrust_lead = lead;
                   });
                 }});
  out.push_back({.id = "dynamic_inflow",
                 .stage = "wrench",
                 .realisation = "thrust follows the speed late",
                 .smallest = 1e-3,
                 .typical = 0.02,
                 .largest = 0.12,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [a](RotorChange& c, int) { c.thrust_lag = a; });
                 }});
  out.push_back({.id = "dynamic_inflow",
                 .stage = "wrench",
                 .realisation = "two kinds of propellers, each late in its way",
                 .smallest = 1e-3,
                 .typical = 0.02,
                 .largest = 0.1,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   each_rotor(f, [a](RotorChange& c, int i) { c.thrust_lag = a * (i % 2 ? 1.4 : 0.6); });
                 }});
  // up to eight times the frontal area of the airframe: more is no multirotor
  out.push_back(
      {.id = "parasitic_drag",
       .stage = "wrench",
       .realisation = "drag of a sphere",
       .law = true,
       .smallest = 0.01,
       .typical = 1,
       .largest = 8,
       .possible = moves,
       .apply = [](FamilyFlight& f, double a, const Shape&) { airframe(f).round_area += a * frontal(f); },
       .parameters = [](const FamilyFlight& f, double a,
                        const Shape&) { return Parameters{scalar("area", a * frontal(f))}; }});
  out.push_back({.id = "parasitic_drag",
                 .stage = "wrench",
                 .realisation = "plates: another area along every axis",
                 .smallest = 0.01,
                 .typical = 1,
                 .largest = 8,
                 .possible = moves,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   airframe(f).drag_area_B +=
                       a * frontal(f) *
                       Vec3(k.between(0, 0.6, 1.0), k.between(1, 0.9, 1.6), k.between(2, 0.8, 2.2));
                 }});
}

void wind(std::vector<Hidden>& out) {
  out.push_back({.id = "wind",
                 .stage = "wrench",
                 .realisation = "steady wind on a sphere, with a profile",
                 .combines = false,
                 .smallest = 0.05,
                 .typical = 1.5,
                 .largest = 7,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       airframe(f).round_area = k.between(2, 0.6, 1.2) * frontal(f);
                       Wind w;
                       w.velocity_W = a * k.direction(0, true);
                       w.profile_exponent = k.between(3, 0.05, 0.2);
                       f.world.wind = w;
                     },
                 .along = {"parasitic_drag"}});
  out.push_back({.id = "wind",
                 .stage = "wrench",
                 .realisation = "steady wind that rotors and plates feel",
                 .combines = false,
                 .smallest = 0.05,
                 .typical = 1.5,
                 .largest = 7,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       airframe(f).drag_area_B = frontal(f) * Vec3(0.4, 0.6, 0.9);
                       rotor_air(f).drag = k.between(2, 0.005, 0.015) * weight(f) /
                                           f.vehicle.nominal.rotor_count() / hover_speed(f);
                       Wind w;
                       w.velocity_W = a * k.direction(0, true);
                       f.world.wind = w;
                     },
                 .along = {"parasitic_drag", "rotor_drag"}});
  out.push_back({.id = "gust",
                 .stage = "wrench",
                 .realisation = "first-order gusts on a sphere",
                 .law = true,
                 .combines = false,
                 .smallest = 0.02,
                 .typical = 1,
                 .largest = 5,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       airframe(f).round_area = k.between(0, 0.8, 1.5) * frontal(f);
                       Wind w;
                       w.velocity_W = 0.5 * a * k.direction(1, true);
                       w.gust_rms = a;
                       w.gust_length = k.between(3, 0.6, 2);
                       f.world.wind = w;
                     },
                 .along = {"wind", "parasitic_drag"}});
  out.push_back({.id = "gust",
                 .stage = "wrench",
                 .realisation = "single gusts of a 1-cosine",
                 .combines = false,
                 .smallest = 0.05,
                 .typical = 2,
                 .largest = 8,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       airframe(f).round_area = k.between(0, 0.8, 1.5) * frontal(f);
                       Wind w;
                       const double length = f.path.duration - f.lead;
                       for (int i = 0; i < 6; ++i) {
                         const double at =
                             f.lead + 1 +
                             length * (0.05 + 0.16 * i + 0.05 * k.u[static_cast<std::size_t>(i)]);
                         w.gusts.push_back({at, 1 + 2 * k.u[static_cast<std::size_t>(i + 1)],
                                            a * exp_rotation(Vec3(0, 0, 1.9 * i)).toRotationMatrix() *
                                                k.direction(3, true)});
                       }
                       f.world.wind = w;
                     },
                 .along = {"wind", "parasitic_drag"}});
  out.push_back({.id = "vortex_ring",
                 .stage = "wrench",
                 .realisation = "loss of thrust in a descent",
                 .law = true,
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.35,
                 .possible = quick,
                 .apply = [](FamilyFlight& f, double a, const Shape&) {
                   rotor_air(f).descent_loss = a;
                   rotor_air(f).descent_center = 0.6;
                 }});
  out.push_back({.id = "vortex_ring",
                 .stage = "wrench",
                 .realisation = "loss of thrust in every slow descent, broad",
                 .combines = false,
                 .smallest = 1e-3,
                 .typical = 0.1,
                 .largest = 0.3,
                 .possible = quick,
                 .apply = [](FamilyFlight& f, double a, const Shape& k) {
                   rotor_air(f).descent_loss = a;
                   rotor_air(f).descent_center = k.between(0, 0.4, 0.6);
                   rotor_air(f).descent_width = k.between(1, 0.2, 0.3);
                 }});
}

}  // namespace

void hide_air(std::vector<Hidden>& out) {
  drag(out);
  wind(out);
}

}  // namespace omniflight::proof
