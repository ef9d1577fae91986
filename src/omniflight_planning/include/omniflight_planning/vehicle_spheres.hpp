// The vehicle as parts (rotor discs at one tilt, collision shapes, arms; triangles of a mesh) and as spheres
// that cover them.
#pragma once

#include <array>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_planning/mesh.hpp"
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
  /// m, body frame: the part, where it is a piece of a mesh; triangle i lies in sphere i.
  std::vector<std::array<Vec3, 3>> triangles = {};
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

/// Spheres of a rigid body whose surface is this mesh, in its frame. Triangles are halved across their
/// longest edge until each lies in a sphere about one of its own points whose radius is at most `share` of
/// the body's bounding radius, or there are kMostBodySpheres; the pieces are grouped by where they are.
/// Nothing is solid: inscribed_radius is 0.
VehicleSpheres cover_with_spheres(const TriangleMesh& body, double share = 0.1);

inline constexpr std::size_t kMostBodySpheres = 4000;  ///< unless there are more triangles

}  // namespace omniflight::planning
