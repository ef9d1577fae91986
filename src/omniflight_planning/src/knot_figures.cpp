#include "knot_figures.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr std::size_t kFiguresBetweenLooks = 64;  // at the clock: 1 ms
constexpr std::size_t kEnergyStride = 5;          // knots of 10 ms: motions change in a tenth of a second

double power_of(const vehicle::Vehicle& vehicle, const vehicle::RotorVector& thrusts) {
  double out = 0.0;
  for (int i = 0; i < vehicle.rotor_count(); ++i) {
    const vehicle::Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    out += rotor.drag_ratio * std::abs(thrusts[i] * rotor.speed(thrusts[i]));
  }
  return out;
}

}  // namespace

Result<std::vector<KnotFigures>> figures_of(const std::vector<TrajectoryKnot>& knots, Tilts& tilts,
                                            const Deadline& deadline) {
  std::vector<KnotFigures> out;
  std::optional<Rotors::Thrusts> thrusts;
  const AtTilt* here = nullptr;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    if (k % kFiguresBetweenLooks == 0 && deadline.passed()) break;
    const Reference& r = knots[k].reference;
    if (!here || r.alpha != knots[k - 1].reference.alpha) {
      const auto found = tilts.at(r.alpha);
      if (!found) return Failure(found.error());
      here = *found;
      thrusts.emplace(*here->rotors);
    }
    const Vec6 wrench = here->rotors->load().required_wrench(r);
    out.push_back({here->check.clearance({r.p_WB, r.q_WB}).distance, 1.0 - here->rotors->load().load(wrench),
                   thrusts->of(wrench)});
  }
  return out;
}

Result<std::optional<double>> energy_of(const std::vector<TrajectoryKnot>& knots, Tilts& tilts,
                                        const vehicle::Vehicle& vehicle, const Deadline& deadline) {
  double out = 0.0;
  std::optional<Rotors::Thrusts> thrusts;
  const AtTilt* here = nullptr;
  double alpha = 0.0;
  for (std::size_t k = 0; k + 1 < knots.size(); k += kEnergyStride) {
    if (deadline.passed()) return std::optional<double>();
    const Reference& r = knots[k].reference;
    if (!here || r.alpha != alpha) {
      const auto found = tilts.at(alpha = r.alpha);
      if (!found) return Failure(found.error());
      here = *found;
      thrusts.emplace(*here->rotors);
    }
    const std::size_t next = std::min(k + kEnergyStride, knots.size() - 1);
    out += power_of(vehicle, thrusts->of(here->rotors->load().required_wrench(r))) *
           (knots[next].t - knots[k].t);
  }
  return std::optional<double>(out);
}

}  // namespace omniflight::planning
