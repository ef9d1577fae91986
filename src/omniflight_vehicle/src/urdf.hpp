// Rigid-body data out of a URDF, guarded: urdfdom itself accepts negative masses, cycles and broken numbers.
#pragma once

#include <string>

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::vehicle {

struct UrdfBody {
  double mass = 0;                     ///< kg, all links
  Mat3 inertia = Mat3::Zero();         ///< kg m^2 about the common centre of mass, root axes
  Vec3 center_of_mass = Vec3::Zero();  ///< m, root frame
  std::vector<CollisionShape> collision;
};

/// All links joined rigidly at joint position zero. Refuses nesting deeper than 64, more than 1000 links,
/// links that are not reachable from the root exactly once, masses that are not positive, and anything
/// urdfdom complains about.
Result<UrdfBody> read_urdf(const std::string& text, const std::string& name);

}  // namespace omniflight::vehicle
