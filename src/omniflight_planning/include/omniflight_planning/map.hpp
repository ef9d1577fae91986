// Distance field over an octree: for any point, how far away the nearest occupied voxel certainly is.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_planning/deadline.hpp"
#include "omniflight_planning/voxel_blocks.hpp"

namespace octomap {
class OcTree;
}

namespace omniflight::planning {

struct StoredField;
struct Zones;

/// What a voxel counts as that the map says nothing about.
enum class UnknownSpace { occupied, free };

struct MapOptions {
  UnknownSpace unknown = UnknownSpace::occupied;  ///< inside the box that the known voxels span
  double max_distance = 1.0;                      ///< m, distances are cut off here
  Deadline deadline = {};                         ///< loading gives up once it has passed
  /// Where load() keeps fields between runs; empty: nowhere. At most 256 MB, the newest.
  std::filesystem::path cache = {};
};

/// $XDG_CACHE_HOME/omniflight or ~/.cache/omniflight; empty where the environment names neither.
std::filesystem::path field_cache_folder();

/// Safe from several threads while nobody closes zones. World frame, metres. Everything outside the
/// box of known voxels counts as an obstacle.
class DistanceMap {
 public:
  static Result<DistanceMap> create(const octomap::OcTree& tree, std::string sha256,
                                    const MapOptions& options = {});
  /// Reads a map (.bt, .ot or a mesh) with the checks of octree_file.hpp, or its field where options.cache
  /// holds it under the file's hash. A field there that is damaged is computed and written again, and
  /// cache_remark() says so.
  static Result<DistanceMap> load(const std::filesystem::path& path, const MapOptions& options = {});

  /// Occupies what the zones close, in place: distances change as far as max_distance() from them. The policy
  /// for unknown space is that of MapOptions. After an error the map is not to be used.
  Status close(const Zones& zones, const Deadline& deadline = {});

  /// Lower bound [m] of the distance from p to the nearest occupied voxel (its box, not its centre) and to
  /// the edge of the map, at most max_distance(); 0 in an occupied voxel, outside or when p is not finite.
  double distance(const Vec3& p) const { return distance_bounds(p).lower; }

  /// Bounds [m] of that distance on both sides.
  struct Bounds {
    double lower = 0.0, upper = 0.0;
  };
  Bounds distance_bounds(const Vec3& p) const;
  /// A smaller lower bound [m], from the voxel that holds p alone, for a third of the time.
  double coarse_distance(const Vec3& p) const;

  bool occupied(int x, int y, int z) const { return field_[index(x, y, z)] == 0.0f; }
  /// Calls visit(center) for every occupied voxel with a free one across a face whose cube may meet the box
  /// from `low` to `high` [m]: whatever is connected, touches obstacles and is not all inside of one touches
  /// such a voxel.
  template <class Visit>
  void for_surface(const Vec3& low, const Vec3& high, const Visit& visit) const {
    constexpr int kEdge = VoxelBlocks::kEdge;
    const std::array<int, 3> from = voxel_of(low), to = voxel_of(high);
    // blocks count one voxel more at the lower side
    for (int z = (from[2] + 1) / kEdge; z <= (to[2] + 1) / kEdge; ++z)
      for (int y = (from[1] + 1) / kEdge; y <= (to[1] + 1) / kEdge; ++y)
        for (int x = (from[0] + 1) / kEdge; x <= (to[0] + 1) / kEdge; ++x)
          for (std::uint64_t bits = blocks_.surface[blocks_.block_of(kEdge * x, kEdge * y, kEdge * z)];
               bits != 0; bits &= bits - 1) {
            const int i = std::countr_zero(bits);
            const std::array<int, 3> at{kEdge * x + i % kEdge - 1, kEdge * y + i / kEdge % kEdge - 1,
                                        kEdge * z + i / (kEdge * kEdge) - 1};
            bool inside = true;
            for (std::size_t k = 0; k < 3; ++k) inside &= at[k] >= from[k] && at[k] <= to[k];
            if (inside) visit(voxel_center(at[0], at[1], at[2]));
          }
  }

  /// Exact distance [m] from the centre of a voxel to the nearest occupied voxel box, cut off at
  /// max_distance().
  double voxel_distance(int x, int y, int z) const { return field_[index(x, y, z)]; }
  bool contains(const Vec3& p) const;
  Vec3 voxel_center(int x, int y, int z) const {
    return lower_ + resolution_ * (Vec3(x, y, z) + Vec3::Constant(0.5));
  }
  std::array<int, 3> voxel_of(const Vec3& p) const;  ///< clamped to the map

  const VoxelBlocks& blocks() const { return blocks_; }
  const Vec3& lower() const { return lower_; }  ///< m, corner of the box
  const Vec3& upper() const { return upper_; }  ///< m
  const std::array<int, 3>& size() const { return size_; }
  double resolution() const { return resolution_; }      ///< m
  double max_distance() const { return max_distance_; }  ///< m
  UnknownSpace unknown() const { return unknown_; }
  const std::string& sha256() const { return sha256_; }              ///< of the file the map came from
  const std::string& cache_remark() const { return cache_remark_; }  ///< empty where there is nothing to say

 private:
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(x);
  }
  void set_field(StoredField field, std::string sha256, const MapOptions& options);

  std::vector<float> field_;  ///< m, x fastest
  VoxelBlocks blocks_;        ///< the same, for what is looked at most often
  std::array<int, 3> size_{};
  Vec3 lower_ = Vec3::Zero(), upper_ = Vec3::Zero();
  double resolution_ = 0.0, voxels_per_metre_ = 0.0, max_distance_ = 0.0;
  UnknownSpace unknown_ = UnknownSpace::occupied;
  std::string sha256_, cache_remark_;
};

/// Of such a squared distance the distance [m], by a few float steps less: a lower bound.
float rounded_down(float squared, double resolution);

/// Exact squared distances, in (half voxel)^2, from voxel centres to the boxes of the occupied voxels of a
/// grid (x fastest); `limit` or more is written as `limit`. Empty once the deadline has passed. Separable
/// lower envelopes of parabolas (Felzenszwalb and Huttenlocher, 2012) with three sites a voxel: its centre
/// and its two faces.
std::vector<float> squared_distances_to_boxes(const std::vector<std::uint8_t>& occupied,
                                              const std::array<int, 3>& size, float limit,
                                              const Deadline& deadline = {});

}  // namespace omniflight::planning
