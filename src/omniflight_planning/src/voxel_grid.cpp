#include "voxel_grid.hpp"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>

#include "omniflight_planning/octree_file.hpp"

namespace omniflight::planning {

Result<VoxelGrid> voxel_grid(const octomap::OcTree& tree, UnknownSpace unknown) {
  VoxelGrid grid;
  if (tree.size() == 0) return bad_input("the map is empty", "map");
  const double res = grid.resolution = tree.getResolution();
  Vec3 upper;
  tree.getMetricMin(grid.lower.x(), grid.lower.y(), grid.lower.z());
  tree.getMetricMax(upper.x(), upper.y(), upper.z());
  const Vec3 cells = (upper - grid.lower) / res;
  if (!cells.allFinite() || cells.minCoeff() < 0.5 ||
      cells.array().round().prod() > static_cast<double>(kMaxMapVoxels))
    return bad_input("the map spans more than 10 million voxels of " + std::to_string(res) + " m", "map",
                     "Crop it or use a coarser resolution");
  for (int k = 0; k < 3; ++k)
    grid.size[static_cast<std::size_t>(k)] = static_cast<int>(std::lround(cells[k]));

  const auto nx = static_cast<std::size_t>(grid.size[0]), ny = static_cast<std::size_t>(grid.size[1]);
  grid.occupied.assign(nx * ny * static_cast<std::size_t>(grid.size[2]),
                       unknown == UnknownSpace::occupied ? 1 : 0);
  bool any = false;
  for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf) {
    const bool full = tree.isNodeOccupied(*leaf);
    any |= full;
    if (!full && unknown == UnknownSpace::free) continue;
    const double half = 0.5 * leaf.getSize();
    const Vec3 first =
        (Vec3(leaf.getX(), leaf.getY(), leaf.getZ()) - Vec3::Constant(half) - grid.lower) / res;
    const int n = static_cast<int>(std::lround(leaf.getSize() / res));
    const auto x0 = static_cast<std::size_t>(std::lround(first.x()));
    const int y0 = static_cast<int>(std::lround(first.y())), z0 = static_cast<int>(std::lround(first.z()));
    for (int z = z0; z < z0 + n; ++z)
      for (int y = y0; y < y0 + n; ++y)
        std::fill_n(grid.occupied.begin() +
                        static_cast<std::ptrdiff_t>(
                            (static_cast<std::size_t>(z) * ny + static_cast<std::size_t>(y)) * nx + x0),
                    n, static_cast<std::uint8_t>(full));
  }
  if (!any) return bad_input("the map has no occupied voxel", "map");
  return grid;
}

}  // namespace omniflight::planning
