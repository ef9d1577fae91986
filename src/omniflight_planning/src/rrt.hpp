// The only file pair that knows OMPL.
#pragma once

#include <optional>
#include <vector>

#include "omniflight_core/random.hpp"
#include "omniflight_planning/planner.hpp"

namespace omniflight::planning {

/// RRTConnect in SE(3) that can be continued. Own sampler and exact linear nearest neighbours: OMPL's random
/// numbers are global to the process, so that a second run would differ from the first.
class Rrt {
 public:
  /// Start and goal must be valid: OMPL aborts the process on a NaN.
  Rrt(const StateCheck& check, const Pose& start, const Pose& goal, std::uint64_t seed);
  ~Rrt();
  /// Continues for at most this long [s]; an exact solution or nothing.
  std::optional<std::vector<Pose>> solve(double seconds);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace omniflight::planning
