// How near a flown path came to the map: for judging flights, after them.
#pragma once

#include <filesystem>
#include <vector>

#include "omniflight_planning/state_check.hpp"

namespace omniflight::planning {

struct FlownPose {
  double t = 0.0;  ///< s
  Pose pose;
  double alpha = 0.0;  ///< rad, tilt of the rotors
};

struct FlownClearance {
  double least =
      0.0;          ///< m, distance of the vehicle's parts to the map; negative: it was hit; cut off at 0.5
  double at = 0.0;  ///< s
  Vec3 p_WB = Vec3::Zero();  ///< m, where the vehicle was then
};

/// The least clearance over the poses, by exact distances to the octree's boxes; unknown space and everything
/// outside the map count as obstacles, as in planning. Rotor discs count as without thickness.
Result<FlownClearance> flown_clearance(const std::vector<FlownPose>& path, const vehicle::Vehicle& vehicle,
                                       const std::filesystem::path& map);

}  // namespace omniflight::planning
