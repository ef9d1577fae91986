// The leaves of an octree as voxels of its finest level, over the box that its known voxels span.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "omniflight_planning/map.hpp"

namespace omniflight::planning {

struct VoxelGrid {
  std::vector<std::uint8_t> occupied;  ///< 1 or 0, x fastest
  std::array<int, 3> size{};
  Vec3 lower = Vec3::Zero();  ///< m, corner of the box
  double resolution = 0.0;    ///< m
};

/// Refuses an octree without nodes, without occupied voxels, or of more than kMaxMapVoxels.
Result<VoxelGrid> voxel_grid(const octomap::OcTree& tree, UnknownSpace unknown);

}  // namespace omniflight::planning
