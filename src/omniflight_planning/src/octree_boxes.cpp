#include "octree_boxes.hpp"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr double kGatherStep = 0.2;  // m, motion after which the boxes nearby are gathered again

}  // namespace

OctreeBoxes::OctreeBoxes(const octomap::OcTree& tree, const Zones& zones) {
  tree.getMetricMin(lower_.x(), lower_.y(), lower_.z());
  tree.getMetricMax(upper_.x(), upper_.y(), upper_.z());
  const auto visit = [&](const auto& self, const octomap::OcTreeNode* node, const Vec3& center,
                         double half) -> void {
    if (((center - upper_).array() >= half).any() || ((lower_ - center).array() >= half).any()) return;
    if (node == nullptr) {
      if (zones.unknown == UnknownSpace::occupied) all_.push_back({center, half});
      return;
    }
    if (!tree.nodeHasChildren(node)) {
      if (tree.isNodeOccupied(node)) all_.push_back({center, half});
      return;
    }
    for (unsigned child = 0; child < 8; ++child) {  // at most 16 levels, see scan_octree
      const Vec3 side((child & 1u) != 0 ? 1.0 : -1.0, (child & 2u) != 0 ? 1.0 : -1.0,
                      (child & 4u) != 0 ? 1.0 : -1.0);
      self(self, tree.nodeChildExists(node, child) ? tree.getNodeChild(node, child) : nullptr,
           center + 0.5 * half * side, 0.5 * half);
    }
  };
  const double half = tree.getResolution() * static_cast<double>(1u << (tree.getTreeDepth() - 1));
  visit(visit, tree.getRoot(), Vec3::Zero(), half);
  const double res = tree.getResolution();
  const Vec3 cells = (upper_ - lower_) / res;
  const std::array<int, 3> size{static_cast<int>(std::lround(cells.x())),
                                static_cast<int>(std::lround(cells.y())),
                                static_cast<int>(std::lround(cells.z()))};
  for (const Primitive& p : zones.keep_out)
    for_touched(p, lower_, size, res, [&](int x, int y, int z) {
      all_.push_back({lower_ + res * (Vec3(x, y, z) + Vec3::Constant(0.5)), 0.5 * res});
    });
  if (zones.keep_in) {
    lower_ = lower_.cwiseMax((*zones.keep_in)[0]);
    upper_ = upper_.cwiseMin((*zones.keep_in)[1]);
  }
}

double OctreeBoxes::clearance(const Pose& pose, const VehicleSpheres& vehicle, double enough) {
  gather(pose.p_WB, vehicle.bounding_radius);
  double best = std::min(enough, kBoxHorizon);
  const Mat3 R = pose.q_WB.toRotationMatrix();
  for (const auto& group : vehicle.groups) {
    if (distance(pose.p_WB + R * group.bound.p_BS) - group.bound.radius >= best) continue;
    double spheres = kBoxHorizon;  // a lower bound: they cover the part
    for (const auto& s : group.spheres)
      spheres = std::min(spheres, distance(pose.p_WB + R * s.p_BS) - s.radius);
    if (spheres >= best) continue;
    const double part = distance(Solid(group.part, pose.p_WB, R), best);
    best = part > 0.0 ? part : std::min(spheres, 0.0);
  }
  return best;
}

double OctreeBoxes::segment_distance(const Vec3& a, const Vec3& b, double enough) const {
  double best = enough;
  for (const Vec3& end : {a, b})
    best = std::min({best, (end - lower_).minCoeff(), (upper_ - end).minCoeff()});
  const Vec3 way = b - a;
  const double square = way.squaredNorm(), length = std::sqrt(square);
  for (const Box& box : all_) {
    const double foot = square > 0.0 ? std::clamp((box.center - a).dot(way) / square, 0.0, 1.0) : 0.0;
    if ((a + foot * way - box.center).norm() - std::sqrt(3.0) * box.half >= best) continue;
    // the distance to a convex body is convex along a line: thirds of the segment are left out in turn
    double low = 0.0, high = 1.0;
    while ((high - low) * length > 1e-5) {
      const double third = (high - low) / 3.0;
      if (box.distance(a + (low + third) * way) <= box.distance(a + (high - third) * way))
        high -= third;
      else
        low += third;
    }
    best = std::min(best, box.distance(a + 0.5 * (low + high) * way) - 0.5 * (high - low) * length);
  }
  return best;
}

void OctreeBoxes::gather(const Vec3& center, double radius) {
  if (gathered_ && (center - around_).norm() < kGatherStep) return;
  near_.clear();
  for (const Box& box : all_)
    if (box.distance(center) <= radius + kBoxHorizon + kGatherStep) near_.push_back(box);
  around_ = center;
  gathered_ = true;
}

double OctreeBoxes::distance(const Solid& solid, double enough) const {
  const Vec3 c = solid.center();
  const Vec3 reach(solid.reach(Vec3::UnitX()), solid.reach(Vec3::UnitY()), solid.reach(Vec3::UnitZ()));
  double best = std::min({enough, (c - reach - lower_).minCoeff(), (upper_ - c - reach).minCoeff()});
  for (const Box& box : near_)
    if (((box.center - c).cwiseAbs() - reach).maxCoeff() - box.half < best)
      best = std::min(best, solid.distance_to_cube(box.center, box.half, best));
  return best;
}

double OctreeBoxes::distance(const Vec3& p) const {
  double best = std::min((p - lower_).minCoeff(), (upper_ - p).minCoeff());
  double square = HUGE_VAL;
  for (const Box& box : near_) square = std::min(square, box.squared_distance(p));
  return std::min(best, std::sqrt(square));
}

}  // namespace omniflight::planning
