// A rigid body of convex parts among convex obstacles: whether a pose is free, and whether a whole motion is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

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
  std::array<Entry, 128> entries = {};
  std::uint32_t hit_part = kNone, hit_obstacle = kNone;  ///< of the last pose that was not free
  std::uint64_t looks = 0;                               ///< places at which a part was measured
};

/// Constant after construction.
class ConvexScene {
 public:
  /// A triangle that belongs to no solid is a part of its own. There must be some of both.
  ConvexScene(const MeshParts& body, const MeshParts& obstacles);

  std::size_t parts() const { return body_.first.size() - 1; }

  /// Whether every part of the body is farther than `least` [m] from every obstacle.
  bool free(const Pose& pose, double least, SeparationMemory& memory) const;

  /// Whether the same is true of every pose of interpolate(a, b, .), of which `a` is known to be free.
  /// Directed conservative advancement (Zhang, Lee and Kim 2006): of every pair, the gap along its separating
  /// axis, less what the part's own points can move along that axis.
  bool motion_free(const Pose& a, const Pose& b, double least, SeparationMemory& memory) const;

 private:
  struct Box {
    Eigen::Array3d low, high;  // m
  };
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;  // of obstacles; count 0: the children are the next node and `second`
    std::uint32_t second = 0;
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

  void split(std::vector<std::uint32_t>& order, std::uint32_t first, std::uint32_t count);
  /// Calls visit(obstacle) for those whose boxes touch this one, until it returns false.
  template <class Visit>
  bool for_near(const Box& box, const Visit& visit) const;
  static Box box_of(const PointsView& points);
  bool apart(std::uint32_t number, const PointsView& part, const Box& box, std::uint32_t obstacle,
             double least, SeparationMemory& memory) const;
  bool stays_apart(const Sweep& sweep, std::uint32_t obstacle, double least, SeparationMemory& memory) const;
  SeparationMemory::Entry& recall(std::uint32_t part, std::uint32_t obstacle, const Box& box,
                                  SeparationMemory& memory) const;

  Hulls body_, obstacles_;
  std::vector<Box> boxes_;  // of the obstacles
  std::vector<Node> nodes_;
};

}  // namespace omniflight::planning
