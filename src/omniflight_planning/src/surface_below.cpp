#include "omniflight_planning/surface_below.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_planning/octree_file.hpp"
#include "voxel_grid.hpp"

namespace omniflight::planning {

Result<SurfaceBelow> SurfaceBelow::create(const octomap::OcTree& tree) {
  auto grid = voxel_grid(tree, UnknownSpace::free);
  if (!grid) return Failure(grid.error());
  SurfaceBelow out;
  out.size_ = grid->size;
  out.lower_ = grid->lower;
  out.resolution_ = grid->resolution;
  const auto& occupied = grid->occupied;
  const std::size_t layer = static_cast<std::size_t>(out.size_[0]) * static_cast<std::size_t>(out.size_[1]);
  out.top_.assign(occupied.size(), 0);
  for (std::size_t at = layer; at < occupied.size(); ++at) {
    const std::size_t below = at - layer;
    const bool on_it = occupied[at] == 0 && occupied[below] != 0;
    out.top_[at] = on_it ? static_cast<std::uint16_t>(at / layer) : out.top_[below];
  }
  // what ends at the upper edge of the map has no voxel above it to tell of it
  out.top_.resize(occupied.size() + layer);
  for (std::size_t k = 0; k < layer; ++k) {
    const std::size_t below = occupied.size() - layer + k;
    out.top_[occupied.size() + k] =
        occupied[below] != 0 ? static_cast<std::uint16_t>(std::min(out.size_[2], 65535)) : out.top_[below];
  }
  return out;
}

Result<SurfaceBelow> SurfaceBelow::load(const std::filesystem::path& path) {
  auto file = read_octree(path);
  if (!file) return Failure(file.error());
  auto out = create(*file->tree);
  if (out) return out;
  Error error = out.error();
  error.where = path.string();
  return Failure(error);
}

std::optional<double> SurfaceBelow::top_in_column(int x, int y, double z) const {
  if (x < 0 || y < 0 || x >= size_[0] || y >= size_[1]) return {};
  const double cell = (z - lower_.z()) / resolution_;
  if (!(cell >= 0.0)) return {};
  const auto layer = static_cast<std::size_t>(std::min(cell, static_cast<double>(size_[2])));
  const std::size_t top = top_[(layer * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y)) *
                                   static_cast<std::size_t>(size_[0]) +
                               static_cast<std::size_t>(x)];
  if (top == 0) return {};
  return lower_.z() + resolution_ * static_cast<double>(top);
}

namespace {

/// Index of the voxel that holds a coordinate [voxels]; one beyond the map for what is far outside of it.
int index_of(double cell, int size) {
  return static_cast<int>(std::floor(std::clamp(cell, -1.0, static_cast<double>(size))));
}

}  // namespace

std::optional<double> SurfaceBelow::top_below(const Vec3& p_W) const {
  if (!p_W.allFinite()) return {};
  const Vec3 cell = (p_W - lower_) / resolution_;
  return top_in_column(index_of(cell.x(), size_[0]), index_of(cell.y(), size_[1]), p_W.z());
}

std::optional<Landing> SurfaceBelow::landing(const Pose& pose, const VehicleSpheres& vehicle) const {
  std::optional<Landing> first;
  for (const SphereGroup& group : vehicle.groups) {
    for (const BodySphere& sphere : group.spheres) {
      const Vec3 center = pose.p_WB + pose.q_WB * sphere.p_BS;
      if (!center.allFinite() || !std::isfinite(sphere.radius)) continue;
      const Vec3 cell = (center - lower_) / resolution_;
      const double reach = sphere.radius / resolution_;
      const int x1 = index_of(cell.x() + reach, size_[0]), y1 = index_of(cell.y() + reach, size_[1]);
      for (int y = index_of(cell.y() - reach, size_[1]); y <= y1; ++y)
        for (int x = index_of(cell.x() - reach, size_[0]); x <= x1; ++x) {
          const double dx = cell.x() - std::clamp(cell.x(), static_cast<double>(x), x + 1.0);
          const double dy = cell.y() - std::clamp(cell.y(), static_cast<double>(y), y + 1.0);
          const double inside = reach * reach - dx * dx - dy * dy;
          if (inside < 0.0) continue;
          const auto top = top_in_column(x, y, center.z());
          if (!top) continue;
          const double bottom = center.z() - resolution_ * std::sqrt(inside);
          const double p_z = pose.p_WB.z() - (bottom - *top);
          if (!first || p_z > first->p_z) first = {p_z, *top};
        }
    }
  }
  return first;
}

}  // namespace omniflight::planning
