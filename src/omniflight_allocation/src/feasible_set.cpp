#include "omniflight_allocation/feasible_set.hpp"

#include <nlohmann/json.hpp>

namespace omniflight::allocation {
namespace {

// Tilt limits of the vehicle; a vehicle that does not tilt has the one tilt 0.
std::pair<double, double> limits(const vehicle::Vehicle& v) {
  return v.tilt.kind == vehicle::TiltKind::none ? std::pair{0.0, 0.0} : std::pair{v.tilt.min, v.tilt.max};
}

Result<double> usable_mass(const vehicle::Vehicle& v, double mass) {
  if (!(mass >= 0) || !std::isfinite(mass))
    return bad_input("mass must be positive, or 0 for the vehicle's, kg", "mass", "Give a positive mass");
  return mass > 0 ? mass : v.mass;
}

nlohmann::json to_json_object(const SetMeasures& m, const char* unit) {
  return {{"unit", unit},
          {"dimension", m.dimension},
          {"holds_zero", m.holds_zero},
          {"d_min_surface", m.d_min_surface},
          {"d_min_vertex", m.d_min_vertex},
          {"d_max", m.d_max},
          {"uniformity_surface", m.uniformity_surface},
          {"uniformity_vertex", m.uniformity_vertex},
          {"facets", m.facets},
          {"vertices", m.vertices}};
}

nlohmann::json to_json_array(const std::vector<Vec3>& points) {
  auto out = nlohmann::json::array();
  for (const Vec3& p : points) out.push_back({p.x(), p.y(), p.z()});
  return out;
}

}  // namespace

Result<std::optional<double>> smallest_omnidirectional_tilt(const vehicle::Vehicle& v, double mass,
                                                            double f_max) {
  const auto used = usable_mass(v, mass);
  if (!used) return Failure(used.error());
  const auto [low, high] = limits(v);
  const double weight = *used * kGravity;
  const auto carried = [&](double alpha) -> Result<bool> {
    const auto set = WrenchSet::create(v, alpha, f_max);
    if (!set) return Failure(set.error());
    return set->omnidirectional_force() >= weight;
  };
  constexpr double kStep = kPi / 180.0;
  double below = low;
  for (int i = 0;; ++i) {
    double alpha = std::min(low + i * kStep, high);
    const auto ok = carried(alpha);
    if (!ok) return Failure(ok.error());
    if (*ok) {
      for (int k = 0; k < 40 && alpha - below > 1e-9; ++k) {
        const double middle = 0.5 * (below + alpha);
        const auto inner = carried(middle);
        if (!inner) return Failure(inner.error());
        (*inner ? alpha : below) = middle;
      }
      return std::optional<double>(alpha);
    }
    if (alpha >= high) return std::optional<double>();
    below = alpha;
  }
}

Result<DesignResult> design(const vehicle::Vehicle& v, const std::vector<double>& alphas, double f_max,
                            double mass) {
  const auto used = usable_mass(v, mass);
  if (!used) return Failure(used.error());
  DesignResult result{v.name, *used, f_max, {}, {}};
  const auto [low, high] = limits(v);
  const Vec3 weight(0, 0, *used * kGravity);
  for (const double alpha : alphas) {
    if (!(alpha >= low - 1e-9 && alpha <= high + 1e-9))
      return bad_input("tilt " + std::to_string(to_degrees(alpha)) + " deg lies outside " +
                           std::to_string(to_degrees(low)) + " to " + std::to_string(to_degrees(high)) +
                           " deg",
                       "alpha", "Choose a tilt within the vehicle's limits");
    const auto set = WrenchSet::create(v, alpha, f_max);
    if (!set) return Failure(set.error());
    DesignPoint p;
    p.alpha = alpha;
    p.rank = set->rank();
    const Polytope force = set->force_at_torque(Vec3::Zero()), torque = set->torque_at_force(Vec3::Zero());
    p.force_at_zero_torque = measure(force);
    p.torque_at_zero_force = measure(torque);
    p.torque_at_hover = measure(set->torque_at_force(weight));
    p.torque_at_any_attitude = measure(set->torque_at_any_attitude(weight.norm()));
    p.mass_limit = p.force_at_zero_torque.d_min_surface / kGravity;
    p.force_vertices = force.vertices;
    p.torque_vertices = torque.vertices;
    p.force_triangles = triangles(force);
    p.torque_triangles = triangles(torque);
    result.points.push_back(std::move(p));
  }
  const auto tilt = smallest_omnidirectional_tilt(v, *used, f_max);
  if (!tilt) return Failure(tilt.error());
  result.omnidirectional_tilt = *tilt;
  return result;
}

void to_json(nlohmann::json& json, const DesignResult& r) {
  auto points = nlohmann::json::array();
  for (const DesignPoint& p : r.points) {
    points.push_back({{"alpha_deg", to_degrees(p.alpha)},
                      {"rank", p.rank},
                      {"force_at_zero_torque", to_json_object(p.force_at_zero_torque, "N")},
                      {"torque_at_zero_force", to_json_object(p.torque_at_zero_force, "Nm")},
                      {"torque_at_hover", to_json_object(p.torque_at_hover, "Nm")},
                      {"torque_at_any_attitude", to_json_object(p.torque_at_any_attitude, "Nm")},
                      {"mass_limit_kg", p.mass_limit},
                      {"force_vertices_N", to_json_array(p.force_vertices)},
                      {"torque_vertices_Nm", to_json_array(p.torque_vertices)}});
  }
  json = {{"schema", "omniflight.design/1"},
          {"vehicle", r.vehicle},
          {"mass_kg", r.mass},
          {"f_max_N", r.f_max > 0 ? nlohmann::json(r.f_max) : nlohmann::json()},
          {"points", points},
          {"smallest_omnidirectional_tilt_deg",
           r.omnidirectional_tilt ? nlohmann::json(to_degrees(*r.omnidirectional_tilt)) : nlohmann::json()}};
}

}  // namespace omniflight::allocation
