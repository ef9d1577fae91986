#include "plausible.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {

VehicleScale scale_of(const vehicle::Vehicle& v, double gravity) {
  VehicleScale s;
  s.mass = v.mass;
  s.weight = v.mass * gravity;
  s.inertia = v.inertia;
  s.inertia_min = v.inertia.diagonal().minCoeff();
  s.inertia_max = v.inertia.diagonal().maxCoeff();
  s.arm = 1e-3;
  double radius = 0;
  for (const vehicle::Rotor& r : v.rotors) {
    s.arm = std::max(s.arm, r.p_BR.norm());
    radius = std::max(radius, r.radius);
  }
  s.disc = kPi * (s.arm + radius) * (s.arm + radius);
  if (v.rotors.empty()) return s;
  s.rotor_thrust = s.weight / static_cast<double>(v.rotors.size());
  s.speed_sum = 0;
  for (const vehicle::Rotor& r : v.rotors) s.speed_sum += std::abs(r.speed(s.rotor_thrust));
  s.speed_sum = std::max(s.speed_sum, 1.0);
  s.rotor_speed = s.speed_sum / static_cast<double>(v.rotors.size());
  return s;
}

Range plausible_range(const physics::Effect& effect, std::size_t parameter, const VehicleScale& s) {
  const physics::EffectInfo& info = effect.info();
  const physics::Parameter& p = info.parameters[parameter];
  Range range{p.lower, p.upper};
  const auto within = [&](double size) {
    range.lower = std::max(range.lower, -size);
    range.upper = std::min(range.upper, size);
  };
  const std::string& id = info.id;
  if (id == "rotor_position_error") {
    within(0.15 * s.arm);
  } else if (id == "thrust_curve") {  // constant and linear part over the thrust of a rotor in hover
    within(0.3 * s.rotor_thrust / (p.name == "linear" ? s.rotor_speed : 1.0));
  } else if (id == "drag_torque_scale") {  // published ratios of like rotors differ by less
    range.lower = std::max(range.lower, s.least_drag_torque);
    range.upper = std::min(range.upper, 1.5);
  } else if (id == "rotor_inertia") {  // a thousandth of the body's is ordinary
    within(0.02 * s.inertia_max);
    range.lower = std::max(range.lower, -0.01 * range.upper);
  } else if (id == "rotor_drag") {  // force over weight per m/s; 0.03 to 0.05 are ordinary
    within(0.15 * s.weight / s.speed_sum);
  } else if (id == "axial_inflow" || id == "vortex_ring") {
    within(0.3 * s.weight / s.speed_sum);
  } else if (id == "blade_flapping") {  // moment over weight times arm per m/s
    within(0.15 * s.weight * s.arm / s.speed_sum);
  } else if (id == "wind") {  // seen from the side
    if (p.unit == "m2") within(0.5 * s.disc);
  } else if (p.unit == "m2") {  // an area times a drag coefficient
    within(2.0 * s.disc);
  } else if (info.id == "com_offset") {
    within(0.5 * s.arm);
  } else if (p.unit == "kg m2" && p.linear) {
    const int axis = p.name.find("xx") == 0   ? 0
                     : p.name.find("yy") == 0 ? 1
                     : p.name.find("zz") == 0 ? 2
                                              : -1;
    range.upper = std::min(range.upper, 0.6 * (axis < 0 ? s.inertia_min : s.inertia(axis, axis)));
    range.lower = std::max(range.lower, -0.5 * s.inertia_min);
  } else if (p.unit == "kg" && p.linear) {
    range.lower = std::max(range.lower, -0.6 * s.mass);
  }
  range.upper = std::max(range.upper, range.lower);
  return range;
}

bool contradicts_itself(const physics::ActiveEffect& e, const VehicleScale& s) {
  const auto index = [&](const char* name) {
    const auto& all = e.effect->info().parameters;
    return static_cast<std::size_t>(
        std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == name; }) - all.begin());
  };
  const auto value = [&](const char* name) { return e.theta[index(name)]; };
  const auto at_limit = [&](const char* name) {
    return value(name) > 0.98 * plausible_range(*e.effect, index(name), s).upper;
  };
  const auto at_either_limit = [&](const char* name) {
    return at_limit(name) || value(name) < 0.98 * plausible_range(*e.effect, index(name), s).lower;
  };
  const std::string& id = e.effect->info().id;
  if (id == "taut_rope")  // stretched by a metre it pulls; what only damps is air
    return value("stiffness") < 0.05 * s.weight || value("damping") > 0.5 * value("stiffness");
  if (id == "wind") return at_limit("area");  // what presses the wind to its limit is another force
  if (id == "cable_torsion")
    return at_either_limit("rest_angle");  // half a turn away it is a constant torque
  if (id == "ceiling_effect") return value("height") < s.highest;
  if (id == "guide_friction") return at_limit("transition");  // what still grows with speed there is drag
  return false;
}

}  // namespace omniflight::diagnosis
