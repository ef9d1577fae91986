#include "omniflight_planning/map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "field_cache.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "voxel_grid.hpp"

namespace omniflight::planning {
namespace {

constexpr double kTimeToWrite = 0.1;  // s, for a field of 10 million voxels

}  // namespace

float rounded_down(float squared, double resolution) {
  return std::sqrt(squared) * static_cast<float>(0.5 * resolution) * (1.0f - 4e-7f);
}

Result<DistanceMap> DistanceMap::create(const octomap::OcTree& tree, std::string sha256,
                                        const MapOptions& options) {
  if (!(options.max_distance > 0.0 && options.max_distance <= 100.0))
    return bad_input("max_distance must lie in (0, 100] m", "map options");
  const auto late = [&] { return out_of_time(options.deadline, "computing the distances of the map"); };
  if (options.deadline.passed()) return late();
  auto grid = voxel_grid(tree, options.unknown);
  if (!grid) return Failure(grid.error());
  const double res = grid->resolution, half_voxels = 2.0 * options.max_distance / res;
  StoredField stored{
      grid->size, grid->lower, res,
      squared_distances_to_boxes(grid->occupied, grid->size, static_cast<float>(half_voxels * half_voxels),
                                 options.deadline)};
  if (stored.field.empty()) return late();
  for (float& value : stored.field) value = rounded_down(value, res);
  DistanceMap map;
  map.set_field(std::move(stored), std::move(sha256), options);
  return map;
}

void DistanceMap::set_field(StoredField stored, std::string sha256, const MapOptions& options) {
  sha256_ = std::move(sha256);
  unknown_ = options.unknown;
  max_distance_ = options.max_distance;
  size_ = stored.size;
  lower_ = stored.lower;
  resolution_ = stored.resolution;
  voxels_per_metre_ = 1.0 / resolution_;
  upper_ = lower_ + resolution_ * Vec3(size_[0], size_[1], size_[2]);
  field_ = std::move(stored.field);
  blocks_ = VoxelBlocks::create(field_, size_, resolution_, max_distance_);
}

Result<DistanceMap> DistanceMap::load(const std::filesystem::path& path, const MapOptions& options) {
  if (options.deadline.passed()) return out_of_time(options.deadline, "about to read the map");
  auto bytes = files::read_file(path, kMaxOctreeBytes);
  if (!bytes) return Failure(bytes.error());
  const std::string sha256 = files::sha256_hex(*bytes);
  std::filesystem::path kept;
  std::string remark;
  if (!options.cache.empty()) {
    if (options.deadline.passed()) return out_of_time(options.deadline, "reading the map");
    // the same bytes under another ending are another map, or none
    const std::string kind = is_mesh(path) ? " mesh " + path.extension().string() : "";
    kept = field_file(options.cache, sha256 + kind, options);
    auto stored = read_field(kept, options);
    if (options.deadline.passed()) return out_of_time(options.deadline, "reading the map's kept field");
    if (!stored) remark = stored.error().text();
    if (stored && *stored) {
      DistanceMap map;
      map.set_field(std::move(**stored), sha256, options);
      return map;
    }
  }
  const auto tree = octree_of(std::move(*bytes), path.string(), options.deadline);
  if (!tree) return Failure(tree.error());
  if (options.deadline.passed()) return out_of_time(options.deadline, "reading the map");
  auto map = create(**tree, sha256, options);
  if (!map) {
    Error error = map.error();
    if (error.code == ErrorCode::bad_input) error.where = path.string();
    return Failure(error);
  }
  if (!kept.empty() && options.deadline.left() > kTimeToWrite)
    write_field(kept, {map->size_, map->lower_, map->resolution_, map->field_});
  map->cache_remark_ = std::move(remark);
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
  double squared = 0.0;  // from the voxel's centre, in voxels
  std::size_t at[3];
  for (int k = 0; k < 3; ++k) {
    const double cell = (p[k] - lower_[k]) * voxels_per_metre_;
    const int i = std::min(static_cast<int>(cell), size_[static_cast<std::size_t>(k)] - 1);
    squared += (cell - i - 0.5) * (cell - i - 0.5);
    at[k] = static_cast<std::size_t>(i);
  }
  const double edge = std::min((p - lower_).minCoeff(), (upper_ - p).minCoeff());
  const float value =
      field_[(at[2] * static_cast<std::size_t>(size_[1]) + at[1]) * static_cast<std::size_t>(size_[0]) +
             at[0]];
  return std::max(0.0, std::min(edge, value - resolution_ * std::sqrt(squared)));
}

DistanceMap::Bounds DistanceMap::distance_bounds(const Vec3& p) const {
  if (!contains(p)) return {};
  const double edge = std::min((p - lower_).minCoeff(), (upper_ - p).minCoeff());
  // The distance to a set is 1-Lipschitz, so each of the eight voxel centres around p bounds it.
  std::size_t offset[3][2];
  float squared[3][2];
  const std::size_t strides[3] = {1, static_cast<std::size_t>(size_[0]),
                                  static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1])};
  for (int k = 0; k < 3; ++k) {
    const int n = size_[static_cast<std::size_t>(k)];
    const double cell = (p[k] - lower_[k]) * voxels_per_metre_ - 0.5;  // at least -0.5
    const int low = std::min(static_cast<int>(std::max(cell, 0.0)), std::max(0, n - 2));
    for (int bit = 0; bit < 2; ++bit) {
      const int at = std::min(low + bit, n - 1);
      const double d = cell - at;
      offset[k][bit] = strides[k] * static_cast<std::size_t>(at);
      squared[k][bit] = static_cast<float>(d * d);
    }
  }
  Eigen::Array<float, 8, 1> value, away;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    value[corner] = field_[offset[0][x] + offset[1][y] + offset[2][z]];
    away[corner] = squared[0][x] + squared[1][y] + squared[2][z];
  }
  int holder = 0;  // the voxel that holds p
  for (int k = 0; k < 3; ++k) holder |= (squared[k][1] < squared[k][0]) << k;
  if (value[holder] == 0.0f) return {};
  away = away.sqrt() * static_cast<float>(resolution_);
  const float lower = (value - away).maxCoeff(), upper = (value + away).minCoeff();
  // single precision: a few units in the last place of the largest value
  const double rounding = 5e-7 * (max_distance_ + resolution_);
  return {std::max(0.0, std::min(static_cast<double>(lower) - rounding, edge)),
          std::min(static_cast<double>(upper) + rounding, edge)};
}

}  // namespace omniflight::planning
