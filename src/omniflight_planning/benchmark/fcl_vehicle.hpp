// FCL's answer to "does the vehicle touch the map here?": its parts as one triangle mesh against the octree,
// the quickest form that FCL offers (spheres and cylinders one by one are slower).
#pragma once

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/octree/octree.h>
#include <fcl/narrowphase/collision.h>

#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/state_check.hpp"

namespace omniflight::planning {

class FclVehicle {
 public:
  using Mesh = fcl::BVHModel<fcl::OBBRSSd>;

  FclVehicle(const VehicleSpheres& vehicle, std::shared_ptr<const octomap::OcTree> tree)
      : mesh_(std::make_shared<Mesh>()), world_(std::make_shared<fcl::OcTreed>(std::move(tree))) {
    mesh_->beginModel();
    for (const SphereGroup& group : vehicle.groups) add(group.part);
    mesh_->endModel();
    object_ = std::make_unique<fcl::CollisionObjectd>(mesh_);
  }
  bool hits(const Pose& pose) const {
    object_->setTransform(pose.q_WB.toRotationMatrix(), pose.p_WB);
    object_->computeAABB();
    fcl::CollisionResultd result;
    return fcl::collide(object_.get(), &world_, fcl::CollisionRequestd(), result) > 0;
  }
  /// OMPL's way with a motion: poses every 1 % of the space's extent (7 cm here, or 1.8 degrees).
  bool motion_free(const Pose& a, const Pose& b) const {
    const double steps =
        std::max((b.p_WB - a.p_WB).norm() / 0.07, a.q_WB.angularDistance(b.q_WB) / to_radians(1.8));
    const int n = std::max(1, static_cast<int>(std::ceil(steps)));
    for (int k = 0; k <= n; ++k)
      if (hits(interpolate(a, b, static_cast<double>(k) / n))) return false;
    return true;
  }

 private:
  void add(const vehicle::CollisionShape& s) {
    using Kind = vehicle::CollisionShape::Kind;
    const auto at = [&](double x, double y, double z) { return Vec3(s.p_BS + s.q_BS * Vec3(x, y, z)); };
    if (s.kind == Kind::box) {
      const Vec3 h = 0.5 * s.size;
      for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
          const auto corner = [&](double u, double v) {
            Vec3 p;
            p[axis] = side, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
            p = p.cwiseProduct(h);
            return at(p.x(), p.y(), p.z());
          };
          mesh_->addTriangle(corner(-1, -1), corner(1, -1), corner(1, 1));
          mesh_->addTriangle(corner(-1, -1), corner(1, 1), corner(-1, 1));
        }
      return;
    }
    // the polygons hold the circles, as the spheres of the other side do
    constexpr int kSides = 16;
    const double r = s.size.x() / std::cos(kPi / kSides), half = 0.5 * s.size.y();
    for (int k = 0; k < kSides; ++k) {
      const double a = 2 * kPi * k / kSides, b = 2 * kPi * (k + 1) / kSides;
      const double ax = r * std::cos(a), ay = r * std::sin(a), bx = r * std::cos(b), by = r * std::sin(b);
      mesh_->addTriangle(at(0, 0, half), at(ax, ay, half), at(bx, by, half));
      if (half <= 0.0) continue;
      mesh_->addTriangle(at(0, 0, -half), at(ax, ay, -half), at(bx, by, -half));
      mesh_->addTriangle(at(ax, ay, -half), at(bx, by, -half), at(bx, by, half));
      mesh_->addTriangle(at(ax, ay, -half), at(bx, by, half), at(ax, ay, half));
    }
  }

  std::shared_ptr<Mesh> mesh_;
  fcl::CollisionObjectd world_;
  std::unique_ptr<fcl::CollisionObjectd> object_;
};

}  // namespace omniflight::planning
