// A distance field in a byte a voxel, in blocks of 4 x 4 x 4 that fill a cache line each: what checks of
// poses read.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_planning/large_pages.hpp"

namespace omniflight::planning {

/// Lengths are in voxels, positions in voxels from the corner of the grid, which has one occupied voxel more
/// on every side than the map: what is outside of the map is an obstacle, and positions outside of the grid
/// are clamped to it. A byte b means that the centre of the voxel is from b to b + 1 quanta away from the
/// nearest occupied voxel's box and from the edge of the map; 0: occupied; top: at least that far.
struct VoxelBlocks {
  static constexpr int kEdge = 4;  ///< voxels

  struct alignas(64) Block {
    std::array<std::uint8_t, 64> near{};  ///< x fastest
  };

  std::vector<Block, LargePages<Block>> blocks;  ///< x fastest, and one that nobody asks for
  /// Of each block, a bit for each occupied voxel with a free one across a face.
  std::vector<std::uint64_t, LargePages<std::uint64_t>> surface;
  /// Of each block, the same as `near` for its voxel (2, 2, 2) in coarser quanta; 0 does not say that it is
  /// occupied.
  std::vector<std::uint8_t> broad;
  std::array<int, 3> count{};                  ///< blocks along each axis
  std::array<int, 3> size{};                   ///< voxels of the map along each axis
  float quantum = 0.0f, broad_quantum = 0.0f;  ///< voxels
  int top = 255, broad_top = 255;

  /// For a field [m], x fastest, that is cut off at max_distance [m].
  static VoxelBlocks create(const std::vector<float>& field, const std::array<int, 3>& size,
                            double resolution, double max_distance);
  /// Again for the voxels from `first` to `last` of the map, around which the field has changed.
  void update(const std::vector<float>& field, double resolution, const std::array<int, 3>& first,
              const std::array<int, 3>& last);

  /// x, y, z: of the grid, one more than those of the map.
  std::size_t block_of(int x, int y, int z) const {
    return (static_cast<std::size_t>(z / kEdge) * static_cast<std::size_t>(count[1]) +
            static_cast<std::size_t>(y / kEdge)) *
               static_cast<std::size_t>(count[0]) +
           static_cast<std::size_t>(x / kEdge);
  }
  static int within(int x, int y, int z) { return (z % kEdge * kEdge + y % kEdge) * kEdge + x % kEdge; }
};

}  // namespace omniflight::planning
