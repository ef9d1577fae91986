#include "triangle_tree.hpp"

#include <algorithm>
#include <numeric>

namespace omniflight::planning {
namespace {

constexpr std::uint32_t kLeaf = 4;  // triangles at most
constexpr std::size_t kStack =
    128;  // boxes that wait: the tree is balanced, 20 levels for a million triangles

}  // namespace

TriangleTree::TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  for (const Triangle& t : triangles_)
    boxes_.push_back(
        {t[0].cwiseMin(t[1]).cwiseMin(t[2]).array(), t[0].cwiseMax(t[1]).cwiseMax(t[2]).array()});
  nodes_.reserve(2 * triangles_.size());
  if (!triangles_.empty()) split(0, static_cast<std::uint32_t>(triangles_.size()));
  for (const Triangle& t : triangles_) planes_.emplace_back(t);
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

void TriangleTree::split(std::uint32_t first, std::uint32_t count) {
  const std::size_t here = nodes_.size();
  Node node{boxes_[first], first, count, 0};
  Eigen::Array3d low = boxes_[first].low + boxes_[first].high, high = low;  // twice the middles
  for (std::uint32_t i = first; i < first + count; ++i) {
    const Box& box = boxes_[i];
    node.box = {node.box.low.min(box.low), node.box.high.max(box.high)};
    low = low.min(box.low + box.high), high = high.max(box.low + box.high);
  }
  nodes_.push_back(node);
  if (count <= kLeaf) return;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), first);
  const std::uint32_t half = count / 2;  // halves: the depth is the logarithm, whatever the triangles are
  std::nth_element(order.begin(), order.begin() + half, order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return boxes_[a].low[axis] + boxes_[a].high[axis] < boxes_[b].low[axis] + boxes_[b].high[axis];
  });
  std::vector<Triangle> moved(count);
  std::vector<Box> moved_boxes(count);
  for (std::uint32_t i = 0; i < count; ++i)
    moved[i] = triangles_[order[i]], moved_boxes[i] = boxes_[order[i]];
  std::copy(moved.begin(), moved.end(), triangles_.begin() + first);
  std::copy(moved_boxes.begin(), moved_boxes.end(), boxes_.begin() + first);
  nodes_[here].count = 0;
  split(first, half);
  nodes_[here].second = static_cast<std::uint32_t>(nodes_.size());
  split(first + half, count - half);
}

double TriangleTree::distance(const Triangle& t, double low, double enough) const {
  if (nodes_.empty()) return enough;
  const Box mine{t[0].cwiseMin(t[1]).cwiseMin(t[2]).array(), t[0].cwiseMax(t[1]).cwiseMax(t[2]).array()};
  const auto square = [&mine](const Box& box) {
    return (box.low - mine.high).max(mine.low - box.high).max(0.0).square().sum();
  };
  struct Waiting {
    std::uint32_t node;
    double square;  // m^2, from its box
  };
  Waiting stack[kStack];
  std::size_t waiting = 0;
  double best = enough;
  const Plane plane(t);
  stack[waiting++] = {0, square(nodes_[0].box)};
  while (waiting > 0) {
    const Waiting now = stack[--waiting];
    if (best <= 0.0 || now.square >= best * best) continue;
    const Node& node = nodes_[now.node];
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
