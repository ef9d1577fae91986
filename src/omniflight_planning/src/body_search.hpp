// RRT-Connect of a rigid body of convex parts.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "convex_scene.hpp"
#include "omniflight_core/random.hpp"
#include "pose_index.hpp"

namespace omniflight::planning {

/// Two trees that grow towards each other (Kuffner and LaValle 2000). A seed gives the same path in every
/// run. Can be continued.
class BodySearch {
 public:
  /// The space has parts and must outlive it; start and goal are valid.
  BodySearch(const BodySpace& space, const Pose& start, const Pose& goal, std::uint64_t seed);

  /// Continues to the deadline and for so many samples at most; a path or nothing.
  std::optional<std::vector<Pose>> solve(const Deadline& end,
                                         std::size_t samples = std::numeric_limits<std::size_t>::max());

 private:
  struct Tree {
    std::vector<Pose> poses;
    std::vector<std::size_t> parents;
    PoseIndex index;
    void add(const Pose& pose, std::size_t parent);
  };
  enum class Extension { trapped, advanced, reached };
  /// From pose number `near` of the tree towards `to`; what was added is its last one.
  Extension extend(Tree& tree, std::size_t near, const Pose& to);
  Pose sample();
  std::vector<Pose> path() const;

  const BodySpace& space_;
  Random random_;
  SeparationMemory memory_;
  Tree trees_[2];  // of the start and of the goal
  std::size_t turn_ = 0;
};

}  // namespace omniflight::planning
