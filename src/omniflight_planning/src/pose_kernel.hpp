// Vehicles against the distance field with vector instructions, chosen at run time; every processor gives the
// same bits.
#pragma once

#include "omniflight_planning/voxel_blocks.hpp"
#include "packed_vehicle.hpp"

namespace omniflight::planning {

/// A pose in voxels from the corner of the grid of VoxelBlocks.
struct GridPose {
  std::array<double, 3> p{};
  std::array<double, 4> q{};  ///< x y z w, a unit quaternion
};

/// Lower bound [voxels] of the distance of the vehicle from obstacles: not above `must` where it is certainly
/// or possibly no farther away than that. At most about `enough`, and the more the coarser. First one look-up
/// for the whole vehicle, then one for each cluster that is not free, then one for each of its spheres; what
/// those leave open is measured between the parts themselves and the voxels in reach of the spheres that are
/// not free.
float room_in_blocks(const VoxelBlocks& blocks, const PackedVehicle& vehicle, const GridPose& pose,
                     float must, float enough);

/// Whether no pose between a and b, on the straight line and the shortest rotation, comes as near as `must`.
/// Where that would take a look at poses less than `least` apart, the answer is no.
/// Bisection: a cluster whose distance in the middle is larger than what its points can move to either end is
/// free in between.
bool motion_in_blocks(const VoxelBlocks& blocks, const PackedVehicle& vehicle, const GridPose& a,
                      const GridPose& b, float must, float least);

}  // namespace omniflight::planning
