// What lies below a vehicle: where a descent straight down ends.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_planning/state_check.hpp"

namespace octomap {
class OcTree;
}

namespace omniflight::planning {

/// First contact of a vehicle that moves straight down in its attitude.
struct Landing {
  double p_z = 0.0;  ///< m, world, height of the body origin at contact; above it when in contact already
  double surface_z = 0.0;  ///< m, world, top of the voxel that is touched
};

/// The tops of an octree's occupied voxels by column. Immutable after construction and safe from several
/// threads; looking up allocates nothing. Only occupied voxels count: ending above space of which the map
/// says nothing would be a fall from there.
class SurfaceBelow {
 public:
  /// Refuses, as DistanceMap, a map without occupied voxels and one of more than kMaxMapVoxels.
  static Result<SurfaceBelow> create(const octomap::OcTree& tree);
  /// Reads a .bt or .ot file with the checks of octree_file.hpp.
  static Result<SurfaceBelow> load(const std::filesystem::path& path);

  /// m, world: the highest top of an occupied voxel below the voxel of p, with a free voxel on it. What
  /// stands beside p, occupied voxels from its own on down, is not below it. Nothing: none there, p outside
  /// the map's columns or not finite.
  std::optional<double> top_below(const Vec3& p_W) const;

  /// The first contact below the vehicle's footprint: of all its spheres with all columns that they overlap.
  /// A sphere sticks out of a rotor disc of radius R by at most 0.29 R, so contact is found that much early.
  std::optional<Landing> landing(const Pose& pose, const VehicleSpheres& vehicle) const;

 private:
  std::optional<double> top_in_column(int x, int y, double z) const;

  std::vector<std::uint16_t> top_;  ///< voxels from the map's lower edge to that top, 0: none; x fastest
  std::array<int, 3> size_{};
  Vec3 lower_ = Vec3::Zero();  ///< m
  double resolution_ = 0.0;    ///< m
};

}  // namespace omniflight::planning
