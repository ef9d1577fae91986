// A rigid body of convex parts among convex obstacles: whether a pose is free, and whether a whole motion is.
#pragma once

#include <cstdint>
#include <vector>

#include "box_tree.hpp"
#include "convex_parts.hpp"
#include "omniflight_planning/state_check.hpp"
#include "separation.hpp"

namespace omniflight::planning {

/// What neighbouring questions know of each other: the axis that separated a part from an obstacle last. It
/// saves time, and changes no answer by more than separation() leaves open. One a search.
struct SeparationMemory {
  struct Entry {
    std::uint32_t part = kNone, obstacle = kNone;
    Vec3 axis = Vec3::UnitX();
  };
  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
  std::vector<Entry> entries = std::vector<Entry>(128);  ///< a power of two
  std::uint32_t hit_part = kNone, hit_obstacle = kNone;  ///< of the last pose that was not free
  std::uint64_t looks = 0;                               ///< places at which a part was measured
};

/// Constant after construction.
class ConvexScene {
 public:
  /// A triangle that belongs to no solid is a part of its own. There must be some of both.
  ConvexScene(const MeshParts& body, const MeshParts& obstacles);

  /// Bodies of more parts have many pairs near each pose.
  static constexpr std::size_t kFewParts = 8;

  std::size_t parts() const { return body_.first.size() - 1; }

  /// As large as pays for a search among so many parts.
  SeparationMemory memory() const;

  /// Whether every part of the body is farther than `least` [m] from every obstacle.
  bool free(const Pose& pose, double least, SeparationMemory& memory) const;

  /// Whether the same is true of every pose of interpolate(a, b, .), of which `a` is known to be free.
  /// Directed conservative advancement (Zhang, Lee and Kim 2006): of every pair, the gap along its separating
  /// axis, less what the part's own points can move along that axis.
  bool motion_free(const Pose& a, const Pose& b, double least, SeparationMemory& memory) const;

 private:
  /// A node of a tree by the middle of its box.
  struct Cell {
    Vec3 middle, half;    // m
    double radius = 0.0;  // m
    std::uint32_t first = 0, count = 0, second = 0;
    explicit Cell(const BoxTree::Node& node);
  };
  /// Points of parts or obstacles one after the other; those of number i from first[i] to first[i + 1].
  struct Hulls {
    std::vector<double> x, y, z;  // m
    std::vector<int> first = {0};
    void add(const std::vector<Vec3>& points);
    int count(std::size_t i) const { return first[i + 1] - first[i]; }
    PointsView operator[](std::size_t i) const {
      const auto at = first[i];
      return {x.data() + at, y.data() + at, z.data() + at, count(i)};
    }
  };
  struct Sweep;
  struct Placement;

  static AlignedBox box_of(const PointsView& points);
  /// Calls visit(part, obstacle) for the pairs that the boxes of the trees do not tell apart, until it
  /// returns false.
  template <class Visit>
  bool for_near_pairs(const Placement& at, const Visit& visit) const;
  bool apart(std::uint32_t number, const PointsView& part, std::uint32_t obstacle, double least,
             SeparationMemory& memory) const;
  bool stays_apart(const Sweep& sweep, std::uint32_t obstacle, double from, double to, double least,
                   SeparationMemory& memory) const;
  SeparationMemory::Entry& recall(std::uint32_t number, const PointsView& part, std::uint32_t obstacle,
                                  SeparationMemory& memory) const;

  Hulls body_, obstacles_;       // as the leaves of their trees have them
  std::vector<Cell> body_tree_;  // in the frame of the body
  std::vector<Cell> world_tree_;
  std::vector<AlignedBox> boxes_;  // of the obstacles
};

}  // namespace omniflight::planning
