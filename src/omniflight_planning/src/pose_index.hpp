// A near pose of many: a k-d tree that grows.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "omniflight_planning/state_check.hpp"

namespace omniflight::planning {

/// Distance [m] of poses: of their origins, and 1 m a unit of the chord between their quaternions, which is
/// half the angle where that is small.
double pose_distance(const Pose& a, const Pose& b);

/// Over position and quaternion (Yershova and LaValle 2007).
class PoseIndex {
 public:
  /// Becomes number size().
  void add(const Pose& pose);
  std::size_t size() const { return size_; }
  /// The number of a pose that is at most 1 + kSlack times as far as the nearest; there must be one. The same
  /// poses in the same order give the same answer.
  std::size_t near(const Pose& pose) const;

  static constexpr double kSlack = 0.5;

 private:
  static constexpr std::size_t kBucket = 32;
  using Row = std::array<float, 7>;  // m; x y z of the quaternion, and its w, which is not negative
  struct Node {
    std::int32_t axis = -1;  // -1: a leaf
    float at = 0.0f;
    std::uint32_t low = 0,
                  high = 0;  // nodes with less than, and at least, `at`; of a leaf, `low` is the bucket
  };
  struct alignas(64) Bucket {
    std::array<std::array<float, kBucket>, 7> rows;  // those that are not there are infinitely far
    std::array<std::uint32_t, kBucket> numbers;
    std::uint32_t count = 0, next = kNone;  // further poses where all are alike
    Bucket();
  };
  struct Best {
    float distance;
    std::uint32_t number;
  };
  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
  static Row row_of(const Pose& pose);
  void put(std::uint32_t bucket, const Row& row, std::uint32_t number);
  void split(std::uint32_t node);
  /// `beyond`: by how much the region of the node is outside of `at` along each axis.
  void search(std::uint32_t node, const Row& at, Row& beyond, Best& best) const;

  std::size_t size_ = 0;
  std::vector<Node> nodes_ = {Node{}};
  std::vector<Bucket> buckets_ = {Bucket{}};
};

}  // namespace omniflight::planning
