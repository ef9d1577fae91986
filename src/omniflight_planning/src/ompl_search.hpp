// The only file pair that knows OMPL.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_planning/planner.hpp"

namespace omniflight::planning {

inline constexpr const char* kRrtConnect = "rrtconnect";

/// One of OMPL's planners in SE(3), by its name in planner_names(), that can be continued. Own sampler for
/// what asks the space for samples. Of rrtconnect no random number is OMPL's own: those are global to the
/// process, so that a second run would differ from the first, as runs of the others do.
class OmplSearch {
 public:
  /// Start and goal must be valid, because OMPL aborts the process on a NaN, and the name one of
  /// planner_names().
  OmplSearch(const std::string& name, const StateCheck& check, const Pose& start, const Pose& goal,
             std::uint64_t seed);
  ~OmplSearch();

  /// Continues to the deadline and for so many samples at most; an exact solution or nothing. Planners that
  /// improve their path use the time to its end.
  std::optional<std::vector<Pose>> solve(const Deadline& end,
                                         std::size_t samples = std::numeric_limits<std::size_t>::max());

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace omniflight::planning
