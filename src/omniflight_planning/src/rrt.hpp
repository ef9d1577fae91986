// The only file pair that knows OMPL.
#pragma once

#include <limits>
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
  /// Continues to the deadline and for so many samples at most; an exact solution or nothing.
  std::optional<std::vector<Pose>> solve(const Deadline& end,
                                         std::size_t samples = std::numeric_limits<std::size_t>::max());

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace omniflight::planning
