#include "omniflight_physics/prior.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace omniflight::physics {
namespace {

using Law = ParameterPrior::Law;
using OfSize = double (*)(const VehicleSize&);

/// One standard deviation of a parameter on a vehicle of this size. Rates that act per rotor speed are scaled
/// by weight over the sum of rotor speeds: a share of the weight per m/s of air.
struct Scale {
  const char* id;
  const char* parameter;  ///< nullptr: all parameters of the effect
  OfSize of;
  std::optional<Law> law = std::nullopt;  ///< otherwise half-normal where the range has one sign, else normal
  OfSize center = nullptr;                ///< otherwise the neutral value
};

// Sources: catalogue ranges of the literature cited in each effect's `source`, made dimensionless with the
// vehicles they were measured on (RotorPy Hummingbird, PX4 iris, Crazyflie, OmniMorph).
constexpr Scale kScales[] = {
    {"payload_mass", nullptr, [](const VehicleSize& s) { return 0.15 * s.mass; }},
    {"com_offset", nullptr, [](const VehicleSize& s) { return 0.05 * s.arm; }},
    {"rotor_axis_misalignment", nullptr, [](const VehicleSize&) { return 0.03; }},
    {"tilt_offset", nullptr, [](const VehicleSize&) { return 0.03; }},
    {"rotor_position_error", nullptr, [](const VehicleSize& s) { return 0.03 * s.arm; }},
    {"thrust_scale", nullptr, [](const VehicleSize&) { return 0.15; }},
    {"rotor_thrust_scale", nullptr, [](const VehicleSize&) { return 0.15; }},
    {"reverse_thrust_asymmetry", nullptr, [](const VehicleSize&) { return 0.2; }},
    {"thrust_curve", "linear", [](const VehicleSize& s) { return 0.1 * s.rotor_thrust / s.rotor_speed; }},
    {"thrust_curve", "constant", [](const VehicleSize& s) { return 0.1 * s.rotor_thrust; }},
    {"drag_torque_scale", nullptr, [](const VehicleSize&) { return 0.25; }},
    {"rotor_inertia", nullptr, [](const VehicleSize& s) { return 0.002 * s.inertia.diagonal().maxCoeff(); }},
    {"tilt_efficiency", nullptr, [](const VehicleSize&) { return 0.3; }},
    {"downwash_interference", "coefficient",
     [](const VehicleSize& s) { return 0.06 * s.weight / s.speed_sum; }},
    // blade element theory: dT/dw = rho a sigma A Omega R / 4 is 0.2 to 0.4 of weight / speed_sum per m/s
    // and momentum theory gives the sign
    {"dynamic_inflow", "coefficient", [](const VehicleSize& s) { return 0.2 * s.weight / s.speed_sum; },
     Law::half_normal},
    {"axial_inflow", nullptr, [](const VehicleSize& s) { return 0.06 * s.weight / s.speed_sum; }},
    {"vortex_ring", nullptr, [](const VehicleSize& s) { return 0.06 * s.weight / s.speed_sum; }},
    {"ceiling_effect", "coefficient", [](const VehicleSize& s) { return 0.06 * s.weight / s.speed_sum; }},
    {"rotor_drag", nullptr, [](const VehicleSize& s) { return 0.04 * s.weight / s.speed_sum; }},
    {"blade_flapping", nullptr, [](const VehicleSize& s) { return 0.02 * s.weight * s.arm / s.speed_sum; }},
    {"parasitic_drag", nullptr, [](const VehicleSize& s) { return 0.06 * s.disc; }},
    {"wind", "x", [](const VehicleSize&) { return 3.0; }},
    {"wind", "y", [](const VehicleSize&) { return 3.0; }},
    {"ground_effect", nullptr, [](const VehicleSize&) { return 1.5; }},
    {"wall_effect", "strength", [](const VehicleSize&) { return 0.03; }},
    {"neighbour_downwash", "strength", [](const VehicleSize& s) { return 0.03 * s.weight; }},
    {"hung_cable", "linear_density", [](const VehicleSize& s) { return 0.12 * s.mass; }},
    {"cable_pendulum", "linear_density", [](const VehicleSize& s) { return 0.12 * s.mass; }},
    {"cable_chain", "linear_density", [](const VehicleSize& s) { return 0.12 * s.mass; }},
    {"catenary", "linear_density", [](const VehicleSize& s) { return 0.06 * s.mass; }},
    {"overhead_rope", "linear_density", [](const VehicleSize& s) { return 0.06 * s.mass; }},
    {"slung_load", "mass", [](const VehicleSize& s) { return 0.15 * s.mass; }},
    {"constant_pull", nullptr, [](const VehicleSize& s) { return 0.08 * s.weight; }},
    {"lateral_stiffness", "stiffness", [](const VehicleSize& s) { return 0.1 * s.weight; }},
    {"taut_rope", "stiffness", [](const VehicleSize& s) { return 5.0 * s.weight; }},
    {"taut_rope", "damping", [](const VehicleSize& s) { return 0.1 * s.weight; }},
    {"hanging_start", "stiffness", [](const VehicleSize& s) { return 5.0 * s.weight; }},
    {"cable_torsion", nullptr, [](const VehicleSize& s) { return 0.01 * s.weight * s.arm; }},
    {"attachment_torque", "x", [](const VehicleSize& s) { return 0.01 * s.mass; }},
    {"attachment_torque", "y", [](const VehicleSize& s) { return 0.01 * s.mass; }},
    {"attachment_torque", "z", [](const VehicleSize& s) { return 0.01 * s.mass; }},
    {"guide_friction", "vertical", [](const VehicleSize& s) { return 0.03 * s.weight; }},
    {"guide_friction", "horizontal", [](const VehicleSize& s) { return 0.03 * s.weight; }},
    {"slung_load", "attachment_x", [](const VehicleSize& s) { return 0.1 * s.arm; }},
    {"slung_load", "attachment_y", [](const VehicleSize& s) { return 0.1 * s.arm; }},
    {"slung_load", "attachment_z", [](const VehicleSize& s) { return 0.3 * s.arm; }},
    // a quarter of the axis; products of inertia 0.3 times that of the smallest
    {"inertia_error", "xx", [](const VehicleSize& s) { return 0.25 * s.inertia(0, 0); }},
    {"inertia_error", "yy", [](const VehicleSize& s) { return 0.25 * s.inertia(1, 1); }},
    {"inertia_error", "zz", [](const VehicleSize& s) { return 0.25 * s.inertia(2, 2); }},
    {"inertia_error", nullptr,
     [](const VehicleSize& s) { return 0.25 * 0.3 * s.inertia.diagonal().minCoeff(); }},
    // a driver brings a rotor to its speed in hover in about 0.1 s, be the rotor small or large; some need
    // ten times as long
    {"actuator_saturation", "slew", [](const VehicleSize&) { return 1.2; }, Law::log_normal,
     [](const VehicleSize& s) { return 10 * s.rotor_speed; }},
};

/// Effects that are rarer or more frequent in practice than the others.
const std::map<std::string, double>& rates() {
  static const std::map<std::string, double> table{
      {"payload_mass", 3},  {"com_offset", 2},       {"thrust_scale", 2},        {"rotor_drag", 3},
      {"hung_cable", 2},    {"slung_load", 2},       {"rotor_inertia", 2},       {"inertia_error", 1},
      {"wall_effect", 0.3}, {"vortex_ring", 0.3},    {"catenary", 0.5},          {"lateral_stiffness", 0.5},
      {"taut_rope", 0.5},   {"hanging_start", 0.3},  {"overhead_rope", 0.5},     {"cable_chain", 0.5},
      {"cable_drag", 0.5},  {"dynamic_inflow", 0.5}, {"attachment_torque", 0.5}, {"ceiling_effect", 0.5},
      {"thrust_curve", 1},  {"guide_friction", 0.5}, {"cable_pendulum", 0.5},    {"cable_torsion", 0.5}};
  return table;
}

}  // namespace

VehicleSize size_of(const vehicle::Vehicle& v, double gravity) {
  VehicleSize s;
  s.mass = v.mass;
  s.weight = v.mass * gravity;
  s.inertia = v.inertia;
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

double ParameterPrior::value(double u) const {
  const double x = law == Law::log_normal ? center * std::exp(scale * u) : center + scale * u;
  return std::clamp(x, lower, upper);
}

double ParameterPrior::slope(double u) const {
  return law == Law::log_normal ? scale * center * std::exp(scale * u) : scale;
}

double ParameterPrior::coordinate(double theta) const {
  return law == Law::log_normal ? std::log(std::max(theta, 1e-12) / center) / scale
                                : (theta - center) / scale;
}

bool is_amplitude(const Parameter& p) { return p.linear || (p.neutral != p.typical && p.neutral == 0); }

ParameterPrior prior_of(const Effect& effect, std::size_t parameter, const VehicleSize& size) {
  const EffectInfo& info = effect.info();
  const Parameter& p = info.parameters[parameter];
  ParameterPrior prior;
  prior.lower = p.lower;
  prior.upper = p.upper;
  prior.center = p.neutral;
  const Law of_range = p.lower >= 0 && p.neutral == 0 ? Law::half_normal : Law::normal;
  for (const Scale& s : kScales)
    if (info.id == s.id && (!s.parameter || p.name == s.parameter)) {
      prior.scale = s.of(size);
      prior.law = s.law.value_or(of_range);
      if (s.center) prior.center = s.center(size);
      if (prior.law == Law::half_normal) prior.lower = std::max(prior.lower, prior.center);
      return prior;
    }
  if (!is_amplitude(p) && p.lower > 0 && p.typical > 0) {  // a length, a time, a speed
    prior.law = Law::log_normal;
    prior.center = p.typical;
    prior.scale = 0.8;
  } else if (is_amplitude(p)) {
    prior.law = of_range;
    prior.scale = std::max(2 * std::abs(p.typical - p.neutral), 1e-3 * (p.upper - p.lower));
  } else {
    prior.center = p.typical;
    prior.scale = std::min(1.0, 0.25 * (p.upper - p.lower));  // a place in the room, an angle, a share
  }
  return prior;
}

double occurrence(const EffectInfo& info) {
  const auto known = rates().find(info.id);
  return known == rates().end() ? 1.0 : known->second;
}

}  // namespace omniflight::physics
