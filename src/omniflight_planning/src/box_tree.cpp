#include "box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace omniflight::planning {

BoxTree::BoxTree(const std::vector<AlignedBox>& boxes, std::uint32_t leaf) : order(boxes.size()) {
  std::iota(order.begin(), order.end(), 0u);
  nodes.reserve(2 * boxes.size());
  if (!boxes.empty()) split(boxes, leaf, 0, static_cast<std::uint32_t>(boxes.size()));
}

void BoxTree::split(const std::vector<AlignedBox>& boxes, std::uint32_t leaf, std::uint32_t first,
                    std::uint32_t count) {
  const std::size_t here = nodes.size();
  Node node{boxes[order[first]], first, count, 0};
  Eigen::Array3d low = node.box.low + node.box.high, high = low;  // twice the middles
  for (std::uint32_t i = first; i < first + count; ++i) {
    const AlignedBox& box = boxes[order[i]];
    node.box = {node.box.low.min(box.low), node.box.high.max(box.high)};
    low = low.min(box.low + box.high), high = high.max(box.low + box.high);
  }
  nodes.push_back(node);
  if (count <= leaf) return;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::uint32_t half = count / 2;
  std::nth_element(order.begin() + first, order.begin() + first + half, order.begin() + first + count,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double middle_a = boxes[a].low[axis] + boxes[a].high[axis];
                     const double middle_b = boxes[b].low[axis] + boxes[b].high[axis];
                     return middle_a < middle_b || (middle_a == middle_b && a < b);
                   });
  nodes[here].count = 0;
  split(boxes, leaf, first, half);
  nodes[here].second = static_cast<std::uint32_t>(nodes.size());
  split(boxes, leaf, first + half, count - half);
}

}  // namespace omniflight::planning
