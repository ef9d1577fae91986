// A binary tree of axis-aligned boxes over many things.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace omniflight::planning {

struct AlignedBox {
  Eigen::Array3d low, high;  // m
};

/// Halves the things across the longest side of the box of their middles, so that the depth is the logarithm
/// of their number, whatever they are. Constant after construction.
struct BoxTree {
  struct Node {
    AlignedBox box;
    std::uint32_t first = 0,
                  count = 0;  // places in `order`; count 0: the children are the next node and `second`
    std::uint32_t second = 0;
  };
  static constexpr std::size_t kMostWaiting =
      128;  // nodes of one or two trees in a walk that goes deep first

  /// `leaf`: things of a leaf at most.
  BoxTree(const std::vector<AlignedBox>& boxes, std::uint32_t leaf);

  std::vector<Node> nodes;           // the root first; none where there are no things
  std::vector<std::uint32_t> order;  // things as the leaves have them

 private:
  void split(const std::vector<AlignedBox>& boxes, std::uint32_t leaf, std::uint32_t first,
             std::uint32_t count);
};

}  // namespace omniflight::planning
