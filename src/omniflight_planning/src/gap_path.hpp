// A path by the widest way, one gap after another; or the gap that ends it.
#pragma once

#include <optional>

#include "gap.hpp"
#include "omniflight_planning/planner.hpp"

namespace omniflight::planning {

struct GapPath {
  std::vector<Pose> poses;       ///< empty: none was found
  bool impossible = false;       ///< proven: not even the ball inside the vehicle gets there
  bool exhausted = false;        ///< every way leads through a gap that nothing was found to fit
  std::optional<Gap> narrowest;  ///< of the gaps that nothing fitted, the one that lacked least
  double lack = 0.0;             ///< m, see Crossing
  bool unholdable = false;
};

/// Start and goal must be valid. Deterministic for the seed of the options.
GapPath path_through_gaps(const StateCheck& check, const Pose& start, const Pose& goal,
                          const PathOptions& options);

}  // namespace omniflight::planning
