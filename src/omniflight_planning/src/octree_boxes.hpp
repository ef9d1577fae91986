// Exact distances to the boxes of an octree: slower than the distance field, and independent of it.
#pragma once

#include <vector>

#include "omniflight_planning/map.hpp"
#include "omniflight_planning/state_check.hpp"
#include "omniflight_planning/zones.hpp"
#include "solid.hpp"

namespace omniflight::planning {

/// Beyond this distance from the vehicle's bounding sphere no box is looked at: clearances are cut off here.
inline constexpr double kBoxHorizon = 0.5;  // m

/// The occupied leaves of an octree, the voxels that zones close, and by the same policy as DistanceMap the
/// space inside the box of known voxels that the map says nothing about; everything outside that box counts
/// as an obstacle.
class OctreeBoxes {
 public:
  explicit OctreeBoxes(const octomap::OcTree& tree, const Zones& zones = {});

  /// Distance [m] of the vehicle's parts to the nearest box or to the edge of the map, exact to 0.1 mm and
  /// never too large, at most `enough` and kBoxHorizon; negative in contact (depth of the spheres).
  /// Neighbouring poses in a row are cheap.
  double clearance(const Pose& pose, const VehicleSpheres& vehicle, double enough = kBoxHorizon);

  /// Distance [m] of a straight segment to the nearest box or to the edge of the map, exact to 0.01 mm and
  /// never too large, at most `enough`.
  double segment_distance(const Vec3& a, const Vec3& b, double enough) const;

 private:
  struct Box {
    Vec3 center;
    double half;  // m
    double squared_distance(const Vec3& p) const {
      return ((p - center).cwiseAbs().array() - half).max(0.0).matrix().squaredNorm();
    }
    double distance(const Vec3& p) const { return std::sqrt(squared_distance(p)); }
  };
  /// Boxes that can matter near `center`; kept until the vehicle has moved 0.2 m.
  void gather(const Vec3& center, double radius);
  double distance(const Vec3& p) const;
  double distance(const Solid& solid, double enough) const;

  std::vector<Box> all_, near_;
  Vec3 lower_ = Vec3::Zero(), upper_ = Vec3::Zero(), around_ = Vec3::Zero();
  bool gathered_ = false;
};

}  // namespace omniflight::planning
