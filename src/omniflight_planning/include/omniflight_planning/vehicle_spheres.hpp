// The vehicle as convex parts (rotor discs at one tilt, collision shapes, arms) and as spheres that cover
// them.
#pragma once

#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

struct BodySphere {
  Vec3 p_BS = Vec3::Zero();  ///< m, centre in the body frame
  double radius = 0.0;       ///< m
};

/// One part of the vehicle: the part itself, spheres that cover it, and one that holds it. The centres of all
/// spheres lie in the part.
struct SphereGroup {
  BodySphere bound;
  std::vector<BodySphere> spheres;
  vehicle::CollisionShape part = {};  ///< a rotor disc is a cylinder of length 0
};

struct VehicleSpheres {
  std::vector<SphereGroup> groups;
  double bounding_radius = 0.0;   ///< m, about the body origin, holds every part
  double inscribed_radius = 0.0;  ///< m, a ball about the body origin that is solid vehicle at every attitude
};

/// Radius [m] that the arms from the body origin to the rotors are assumed to have where the vehicle has no
/// collision shapes of its own.
inline constexpr double kAssumedArmRadius = 0.01;

/// Spheres of a vehicle at tilt alpha [rad]. They cover every disc and shape, and stick out of a disc of
/// radius R by at most 0.29 R.
VehicleSpheres cover_with_spheres(const vehicle::Vehicle& vehicle, double alpha);

}  // namespace omniflight::planning
