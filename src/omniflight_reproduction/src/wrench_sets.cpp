#include "wrench_sets.hpp"

#include <fmt/format.h>

#include "geometries.hpp"
#include "omniflight_allocation/outline.hpp"

namespace omniflight::reproduction {
namespace {

using allocation::measure;
using allocation::SetMeasures;
using allocation::WrenchSet;

// The sliced set nearest to the printed numbers, of four spin patterns, drag ratios of 0.012 to 0.025 m and
// thrusts of 4.2 to 15.6 N: fitted here, within 2 points, and not unique.
constexpr double kFittedDragRatio = 0.012;  // m
constexpr double kFittedThrust = 7.5;       // N, upright

double percent(double share) { return 100 * share; }

}  // namespace

Result<std::vector<Reading>> force_uniformity(const vehicle::Vehicle& v, double alpha) {
  const auto set = WrenchSet::create(without_drag(v), alpha, kChapter5Limit);
  if (!set) return Failure(set.error());
  const SetMeasures m = measure(set->force_at_torque(Vec3::Zero()));
  const double mean = 0.5 * (m.uniformity_surface + m.uniformity_vertex);
  return std::vector<Reading>{
      {"nearest point of the surface over farthest point, as printed", percent(m.uniformity_surface)},
      {"nearest vertex over farthest", percent(m.uniformity_vertex)},
      {"mean of the two", percent(mean)}};
}

Result<std::vector<Reading>> torque_uniformity(const vehicle::Vehicle& v, double alpha) {
  const auto bare = WrenchSet::create(without_drag(v), alpha, kChapter5Limit);
  if (!bare) return Failure(bare.error());
  vehicle::Vehicle dragging = v;
  for (auto& rotor : dragging.rotors) {
    rotor.drag_ratio = kFittedDragRatio;
    rotor.spin = rotor.p_BR.prod() > 0 ? 1 : -1;
  }
  const auto drag = WrenchSet::create(dragging, alpha, kChapter5Limit);
  if (!drag) return Failure(drag.error());
  const SetMeasures any = measure(bare->torque_at_any_attitude(kTableMass * kGravity)),
                    zero = measure(bare->torque_at_force(Vec3::Zero())),
                    upright = measure(bare->torque_at_force(kTableMass * kGravity * Vec3::UnitZ())),
                    sliced = measure(drag->torque_at_force(kFittedThrust * Vec3::UnitZ()));
  return std::vector<Reading>{
      {"m g carried in any direction, 1.595 kg, nearest surface (the caption)",
       percent(any.uniformity_surface)},
      {"zero force, nearest vertex, no drag torque", percent(zero.uniformity_vertex)},
      {"zero force, nearest surface, no drag torque", percent(zero.uniformity_surface)},
      {"1.595 kg upright, nearest vertex, no drag torque", percent(upright.uniformity_vertex)},
      {"7.5 N upright, drag ratio 0.012 m, spins by the sign of x y z, nearest vertex (three knobs fitted "
       "here)",
       percent(sliced.uniformity_vertex)}};
}

Result<report::Outlines> hulls(const std::vector<std::pair<std::string, vehicle::Vehicle>>& vehicles,
                               const std::vector<double>& alphas, bool torques) {
  const std::string quantity = torques ? "M" : "F", unit = torques ? "Nm" : "N";
  report::Outlines out{.title =
                           torques ? "Torques at zero force, body axes" : "Forces at zero torque, body axes"};
  for (const int up : {1, 2})
    out.views.push_back({.x_label = quantity + "x [" + unit + "]",
                         .y_label = fmt::format("{}{} [{}]", quantity, up == 1 ? "y" : "z", unit)});
  for (const auto& [name, v] : vehicles)
    for (const double alpha : v.tilt.kind == vehicle::TiltKind::none ? std::vector<double>{0} : alphas) {
      const auto set = WrenchSet::create(without_drag(v), alpha, kChapter5Limit);
      if (!set) return Failure(set.error());
      const auto body = torques ? set->torque_at_force(Vec3::Zero()) : set->force_at_torque(Vec3::Zero());
      const std::string label = v.tilt.kind == vehicle::TiltKind::none
                                    ? name
                                    : fmt::format("{}{:.4g} deg", name, to_degrees(alpha));
      for (std::size_t k = 0; k < 2; ++k)
        out.views[k].outlines.push_back(
            {label, allocation::outline(body.vertices, 0, static_cast<int>(k) + 1)});
    }
  return out;
}

}  // namespace omniflight::reproduction
