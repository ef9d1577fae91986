#include "omniflight_planning/map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "omniflight_planning/octree_file.hpp"
#include "voxel_grid.hpp"

namespace omniflight::planning {

Result<DistanceMap> DistanceMap::create(const octomap::OcTree& tree, std::string sha256,
                                        const MapOptions& options) {
  if (!(options.max_distance > 0.0 && options.max_distance <= 100.0))
    return bad_input("max_distance must lie in (0, 100] m", "map options");
  const auto late = [&] { return out_of_time(options.deadline, "computing the distances of the map"); };
  if (options.deadline.passed()) return late();
  auto grid = voxel_grid(tree, options.unknown);
  if (!grid) return Failure(grid.error());
  DistanceMap map;
  map.sha256_ = std::move(sha256);
  map.unknown_ = options.unknown;
  map.size_ = grid->size;
  map.lower_ = grid->lower;
  const double res = map.resolution_ = grid->resolution;
  map.upper_ = map.lower_ + res * Vec3(map.size_[0], map.size_[1], map.size_[2]);

  const double half_voxels = 2.0 * options.max_distance / res;
  map.field_ = squared_distances_to_boxes(grid->occupied, map.size_,
                                          static_cast<float>(half_voxels * half_voxels), options.deadline);
  if (map.field_.empty()) return late();
  map.max_distance_ = options.max_distance;
  // Rounded down by a few float steps, so that it stays a lower bound.
  for (float& value : map.field_) value = std::sqrt(value) * static_cast<float>(0.5 * res) * (1.0f - 4e-7f);
  map.find_surface();
  return map;
}

Result<DistanceMap> DistanceMap::load(const std::filesystem::path& path, const MapOptions& options) {
  if (options.deadline.passed()) return out_of_time(options.deadline, "about to read the map");
  auto file = read_octree(path);
  if (!file) return Failure(file.error());
  if (options.deadline.passed()) return out_of_time(options.deadline, "reading the map");
  auto map = create(*file->tree, file->sha256, options);
  if (!map) {
    Error error = map.error();
    if (error.code == ErrorCode::bad_input) error.where = path.string();
    return Failure(error);
  }
  return map;
}

bool DistanceMap::contains(const Vec3& p) const {
  return (p.array() >= lower_.array()).all() && (p.array() <= upper_.array()).all();  // false for NaN
}

std::array<int, 3> DistanceMap::voxel_of(const Vec3& p) const {
  const Vec3 cell = (p - lower_) / resolution_;
  std::array<int, 3> out{};
  for (std::size_t k = 0; k < 3; ++k)
    out[k] = static_cast<int>(std::clamp(cell[static_cast<int>(k)], 0.0, size_[k] - 1.0));
  return out;
}

double DistanceMap::coarse_distance(const Vec3& p) const {
  if (!contains(p)) return 0.0;
  const std::array<int, 3> at = voxel_of(p);
  const double from_center = (p - voxel_center(at[0], at[1], at[2])).norm();
  const double edge = std::min((p - lower_).minCoeff(), (upper_ - p).minCoeff());
  return std::max(0.0, std::min(edge, field_[index(at[0], at[1], at[2])] - from_center));
}

DistanceMap::Bounds DistanceMap::distance_bounds(const Vec3& p) const {
  if (!contains(p)) return {};
  const double edge = std::min((p - lower_).minCoeff(), (upper_ - p).minCoeff());
  // The distance to a set is 1-Lipschitz, so each of the eight voxel centres around p bounds it.
  const Vec3 cell = (p - lower_) / resolution_ - Vec3::Constant(0.5);
  std::size_t offset[3][2];
  float squared[3][2];
  for (int k = 0; k < 3; ++k) {
    const int n = size_[static_cast<std::size_t>(k)];
    const int low = std::clamp(static_cast<int>(std::floor(cell[k])), 0, std::max(0, n - 2));
    const std::size_t stride = k == 0 ? 1
                               : k == 1
                                   ? static_cast<std::size_t>(size_[0])
                                   : static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
    for (int bit = 0; bit < 2; ++bit) {
      const int at = std::min(low + bit, n - 1);
      const double d = cell[k] - at;
      offset[k][bit] = stride * static_cast<std::size_t>(at);
      squared[k][bit] = static_cast<float>(d * d);
    }
  }
  float value[8], away[8];
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    value[corner] = field_[offset[0][x] + offset[1][y] + offset[2][z]];
    away[corner] = squared[0][x] + squared[1][y] + squared[2][z];
  }
  int holder = 0;  // the voxel that holds p
  for (int k = 0; k < 3; ++k) holder |= (squared[k][1] < squared[k][0]) << k;
  if (value[holder] == 0.0f) return {};
  const auto res = static_cast<float>(resolution_);
  float lower = 0.0f, upper = std::numeric_limits<float>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const float d = res * std::sqrt(away[corner]);
    lower = std::max(lower, value[corner] - d);
    upper = std::min(upper, value[corner] + d);
  }
  // single precision: a few units in the last place of the largest value
  const double rounding = 5e-7 * (max_distance_ + resolution_);
  return {std::max(0.0, std::min(static_cast<double>(lower) - rounding, edge)),
          std::min(static_cast<double>(upper) + rounding, edge)};
}

void DistanceMap::find_surface() {
  const auto [nx, ny, nz] = size_;
  surface_.assign(row(0, nz), 0);
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        if (!occupied(x, y, z)) continue;
        const bool hidden = (x == 0 || occupied(x - 1, y, z)) && (x + 1 == nx || occupied(x + 1, y, z)) &&
                            (y == 0 || occupied(x, y - 1, z)) && (y + 1 == ny || occupied(x, y + 1, z)) &&
                            (z == 0 || occupied(x, y, z - 1)) && (z + 1 == nz || occupied(x, y, z + 1));
        if (!hidden) surface_[row(y, z) + static_cast<std::size_t>(x / 64)] |= std::uint64_t{1} << (x % 64);
      }
}

}  // namespace omniflight::planning
