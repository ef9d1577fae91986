// A convex part of the vehicle placed in the world, and how far it is from voxels, to the last tenth of a
// millimetre.
#pragma once

#include "omniflight_planning/vehicle_spheres.hpp"

namespace omniflight::planning {

/// Sphere, cylinder (of length 0: a disc without thickness) or box.
class Solid {
 public:
  /// `shape` in the body frame, the body at p_WB with rotation matrix R_WB.
  Solid(const vehicle::CollisionShape& shape, const Vec3& p_WB, const Mat3& R_WB)
      : kind_(shape.kind), size_(shape.size), center_(p_WB + R_WB * shape.p_BS) {
    if (kind_ != vehicle::CollisionShape::Kind::sphere) R_WS_ = R_WB * shape.q_BS.toRotationMatrix();
  }

  const Vec3& center() const { return center_; }
  /// Largest extent [m] from the centre along a unit vector.
  double reach(const Vec3& unit) const;
  /// The point of the solid nearest to x.
  Vec3 nearest(const Vec3& x) const;

  /// Lower bound [m] of the distance to the axis-aligned cube; exact to 0.1 mm unless it is at least
  /// `enough`, where any bound that is will do. 0 in contact.
  double distance_to_cube(const Vec3& center, double half, double enough) const;

 private:
  /// Gap [m] between solid and cube along a unit vector, from the one side or the other; negative where their
  /// shadows overlap. Never more than their distance (separating axis).
  double gap_along(const Vec3& unit, const Vec3& cube, double half) const;

  vehicle::CollisionShape::Kind kind_;
  Vec3 size_;
  Vec3 center_;
  Mat3 R_WS_ = Mat3::Identity();
};

}  // namespace omniflight::planning
