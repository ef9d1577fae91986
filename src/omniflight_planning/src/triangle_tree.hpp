// How near a triangle comes to many others: a tree of boxes.
#pragma once

#include <cstdint>
#include <vector>

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
  struct Box {
    Eigen::Array3d low, high;  // m
  };
  struct Node {
    Box box;
    std::uint32_t first = 0,
                  count = 0;  // of triangles_; count 0: the children are the next node and `second`
    std::uint32_t second = 0;
  };
  void split(std::uint32_t first, std::uint32_t count);

  /// Unit normal and offset [m] of a triangle's plane; no normal where it has no area.
  struct Plane {
    Vec3 normal = Vec3::Zero();
    double offset = 0.0;
    explicit Plane(const Triangle& t);
    /// Distance [m] that a triangle keeps from the plane on one side of it, which is none to its own
    /// triangle.
    double gap(const Triangle& t) const;
  };

  std::vector<Triangle> triangles_;
  std::vector<Plane> planes_;  // of the triangles
  std::vector<Box> boxes_;     // of the triangles
  std::vector<Node> nodes_;
};

}  // namespace omniflight::planning
