// How near a triangle comes to many others: a tree of boxes.
#pragma once

#include <vector>

#include "box_tree.hpp"
#include "triangle.hpp"

namespace omniflight::planning {

/// Constant after construction and safe from several threads.
class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles);

  /// Distance [m] of `t` to the nearest triangle of the tree, or `enough` where it is at least that; no more
  /// than `low` is told as any number up to there.
  double distance(const Triangle& t, double low, double enough) const;

 private:
  /// Unit normal and offset [m] of a triangle's plane; no normal where it has no area.
  struct Plane {
    Vec3 normal = Vec3::Zero();
    double offset = 0.0;
    explicit Plane(const Triangle& t);
    /// Distance [m] that a triangle keeps from the plane on one side of it, which is none to its own
    /// triangle.
    double gap(const Triangle& t) const;
  };

  std::vector<Triangle> triangles_;  // as the leaves have them
  std::vector<Plane> planes_;        // of the triangles
  std::vector<AlignedBox> boxes_;    // of the triangles
  std::vector<BoxTree::Node> nodes_;
};

}  // namespace omniflight::planning
