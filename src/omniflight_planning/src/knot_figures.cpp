#include "knot_figures.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kFiguresBetweenLooks = 64;  // at the clock: 1 ms

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

}  // namespace omniflight::planning
