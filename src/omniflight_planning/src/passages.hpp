// The free space of a map in blocks of about 0.1 m: the widest way of a point from here to there, and whether
// there is any.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "omniflight_planning/deadline.hpp"
#include "omniflight_planning/map.hpp"

namespace omniflight::planning {

/// A place of a way and how far the nearest obstacle is.
struct WayPlace {
  Vec3 p_W = Vec3::Zero();
  double distance = 0.0;  ///< m
};

class Passages {
 public:
  /// Reads the whole map once. The map must outlive it.
  explicit Passages(const DistanceMap& map);

  /// The way from a to b whose narrowest place is widest, distances of `wide` [m] and more being alike, and
  /// among such ways a short one: the roomiest voxels of the blocks it passes. The narrowest place is right
  /// to 1/64 of `wide`. Nothing where no free blocks connect a and b, or the deadline has passed.
  std::optional<std::vector<WayPlace>> widest_way(const Vec3& a, const Vec3& b, double least, double wide,
                                                  const Deadline& deadline) const;

  /// False only where no ball of the radius that `least` belongs to can move from a to b: every point of a
  /// block is nearer to an obstacle than least plus half of a voxel's diagonal unless the block is passed
  /// here. Blocks share faces: a way through a shared edge or corner passes all blocks there.
  bool may_pass(const Vec3& a, const Vec3& b, double least, const Deadline& deadline) const;

  /// Blocks whose roomiest voxel lies outside of this box [m] count as full from now on.
  void keep_to(const Vec3& lower, const Vec3& upper);

  /// Blocks within `radius` [m] of p that are no wider than `distance` [m] count as full from now on: the
  /// rest of a gap whose widest place is p.
  void close(const Vec3& p, double radius, double distance);

 private:
  struct Block {
    float distance;       // m, of its roomiest voxel's centre
    std::uint32_t voxel;  // that voxel
  };
  std::size_t block_of(const Vec3& p) const;
  Vec3 place(std::size_t block) const;
  template <class Visit>
  void for_neighbours(std::size_t block, const Visit& visit) const;

  const DistanceMap& map_;
  int voxels_;  // along an edge of a block
  std::array<int, 3> size_{};
  std::vector<Block> blocks_;
};

}  // namespace omniflight::planning
