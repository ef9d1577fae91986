// RRT-Connect from pose to pose.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "convex_scene.hpp"
#include "omniflight_core/random.hpp"
#include "pose_index.hpp"

namespace omniflight::planning {

/// Two trees that grow towards each other (Kuffner and LaValle 2000). A seed gives the same path in every
/// run. Can be continued. Positions are uniform in the map, or in the box of a body. Attitudes of vehicles
/// are mostly between start and goal, because a mission that keeps its attitude should not tumble on the way;
/// those of bodies are uniform. Every motion of a vehicle's path has passed motion_valid.
class ConnectSearch {
 public:
  /// The check must outlive it; start and goal are valid.
  ConnectSearch(const StateCheck& check, const Pose& start, const Pose& goal, std::uint64_t seed);

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
  bool motion_free(const Tree& tree, const Pose& from, const Pose& to);
  Pose sample();
  std::vector<Pose> path() const;

  const StateCheck& check_;
  const BodySpace* parts_;  // of a body of convex parts; else null
  Pose start_, goal_;
  Vec3 lower_, upper_;  // m, of positions
  double range_;        // m, of one motion, by pose_distance()
  Random random_;
  SeparationMemory memory_;
  Tree trees_[2];  // of the start and of the goal
  std::size_t turn_ = 0;
};

}  // namespace omniflight::planning
