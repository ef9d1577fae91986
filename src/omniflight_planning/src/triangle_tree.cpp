#include "triangle_tree.hpp"

#include <algorithm>

namespace omniflight::planning {
namespace {

constexpr std::uint32_t kLeaf = 4;  // triangles at most

AlignedBox box_around(const Triangle& t) {
  return {t[0].cwiseMin(t[1]).cwiseMin(t[2]).array(), t[0].cwiseMax(t[1]).cwiseMax(t[2]).array()};
}

}  // namespace

TriangleTree::TriangleTree(std::vector<Triangle> triangles) {
  std::vector<AlignedBox> boxes;
  for (const Triangle& t : triangles) boxes.push_back(box_around(t));
  BoxTree tree(boxes, kLeaf);
  nodes_ = std::move(tree.nodes);
  for (const std::uint32_t i : tree.order) {
    triangles_.push_back(triangles[i]);
    boxes_.push_back(boxes[i]);
    planes_.emplace_back(triangles[i]);
  }
}

TriangleTree::Plane::Plane(const Triangle& t) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double length = n.norm();
  if (length > 0.0) normal = n / length;
  offset = normal.dot(t[0]);
}

double TriangleTree::Plane::gap(const Triangle& t) const {
  const double a = normal.dot(t[0]) - offset, b = normal.dot(t[1]) - offset, c = normal.dot(t[2]) - offset;
  return std::max(std::min({a, b, c}), -std::max({a, b, c}));
}

double TriangleTree::distance(const Triangle& t, double low, double enough) const {
  if (nodes_.empty()) return enough;
  const AlignedBox mine = box_around(t);
  const auto square = [&mine](const AlignedBox& box) {
    return (box.low - mine.high).max(mine.low - box.high).max(0.0).square().sum();
  };
  struct Waiting {
    std::uint32_t node;
    double square;  // m^2, from its box
  };
  Waiting stack[BoxTree::kMostWaiting];
  std::size_t waiting = 0;
  double best = enough;
  const Plane plane(t);
  stack[waiting++] = {0, square(nodes_[0].box)};
  while (waiting > 0) {
    const Waiting now = stack[--waiting];
    if (best <= 0.0 || now.square >= best * best) continue;
    const BoxTree::Node& node = nodes_[now.node];
    if (node.count == 0) {
      Waiting near{now.node + 1, square(nodes_[now.node + 1].box)};
      Waiting far{node.second, square(nodes_[node.second].box)};
      if (far.square < near.square) std::swap(near, far);
      stack[waiting++] = far;
      stack[waiting++] = near;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      // a plane between the two tells of most that they are no nearer
      if (square(boxes_[i]) >= best * best || planes_[i].gap(t) >= best || plane.gap(triangles_[i]) >= best)
        continue;
      best = std::min(best, triangles_distance(t, triangles_[i]));
    }
    if (best <= low) return best;
  }
  return best;
}

}  // namespace omniflight::planning
