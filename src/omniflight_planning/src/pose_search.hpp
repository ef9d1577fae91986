// RRT-Connect from pose to pose: of a body of convex parts our own, of everything else OMPL's.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "body_search.hpp"
#include "ompl_search.hpp"

namespace omniflight::planning {

/// A seed gives the same path in every run. Can be continued.
class PoseSearch {
 public:
  /// Start and goal are valid; the check must outlive it.
  PoseSearch(const StateCheck& check, const Pose& start, const Pose& goal, std::uint64_t seed) {
    if (check.space() && check.space()->parts)
      body_ = std::make_unique<BodySearch>(*check.space(), start, goal, seed);
    else
      vehicle_ = std::make_unique<OmplSearch>(kRrtConnect, check, start, goal, seed);
  }

  /// Continues to the deadline and for so many samples at most; a path or nothing.
  std::optional<std::vector<Pose>> solve(const Deadline& end,
                                         std::size_t samples = std::numeric_limits<std::size_t>::max()) {
    return body_ ? body_->solve(end, samples) : vehicle_->solve(end, samples);
  }

 private:
  std::unique_ptr<BodySearch> body_;
  std::unique_ptr<OmplSearch> vehicle_;
};

}  // namespace omniflight::planning
