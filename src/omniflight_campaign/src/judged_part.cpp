#include "omniflight_campaign/judged_part.hpp"

namespace omniflight::campaign {

std::optional<std::pair<double, double>> motion_of(const Trajectory& trajectory) {
  std::optional<std::pair<double, double>> out;
  for (const TrajectoryKnot& k : trajectory.knots())
    if (k.reference.v_WB_W.norm() >= 1e-9 || k.reference.w_WB_B.norm() >= 1e-9)
      out = {out ? out->first : k.t, k.t};
  return out;
}

}  // namespace omniflight::campaign
