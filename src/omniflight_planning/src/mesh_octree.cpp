#include <octomap/OcTree.h>

#include <cmath>
#include <numeric>

#include "omniflight_planning/mesh.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "text.hpp"
#include "triangle.hpp"

namespace omniflight::planning {
namespace {

constexpr int kDepth = 16;  // levels of an octree
constexpr int kHalf = 1 << (kDepth - 1);
constexpr std::size_t kNodesBetweenLooks = 1024;

using Key = std::array<int, 3>;  // voxels of the finest level from the world's origin

/// Fills an octree from the root: a node that no triangle touches is one free leaf.
class Voxeliser {
 public:
  Voxeliser(const TriangleMesh& mesh, octomap::OcTree& tree, const Key& low, const Key& high,
            const Deadline& deadline)
      : mesh_(mesh), tree_(tree), low_(low), high_(high), deadline_(deadline), res_(tree.getResolution()) {}

  enum class End { done, late, too_many };

  End run() {
    std::vector<std::uint32_t> all(mesh_.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    // OctoMap makes the root with the first leaf
    tree_.setNodeValue(octomap::OcTreeKey(key(low_[0]), key(low_[1]), key(low_[2])), free_, true);
    fill(tree_.getRoot(), {-kHalf, -kHalf, -kHalf}, 2 * kHalf, 0, all);
    return end_;
  }

 private:
  static octomap::key_type key(int k) { return static_cast<octomap::key_type>(k + kHalf); }

  void fill(octomap::OcTreeNode* node, const Key& at, int size, int depth,
            const std::vector<std::uint32_t>& candidates) {
    if (end_ != End::done) return;
    if (++nodes_ > kMaxOctreeNodes) return void(end_ = End::too_many);
    if (nodes_ % kNodesBetweenLooks == 0 && deadline_.passed()) return void(end_ = End::late);
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) inside = inside && at[k] >= low_[k] && at[k] + size <= high_[k];
    const Vec3 half = Vec3::Constant(0.5 * res_ * size);
    const Vec3 center = res_ * Vec3(at[0], at[1], at[2]) + half;
    std::vector<std::uint32_t> touching;
    for (const std::uint32_t i : candidates)
      if (touches_box(mesh_.corners(i), center, half)) touching.push_back(i);
    // the way to the first leaf has nodes already, which are filled to the end
    if (depth == kDepth || (inside && touching.empty() && !tree_.nodeHasChildren(node)))
      return node->setLogOdds(touching.empty() ? free_ : occupied_);
    const int part = size / 2;
    for (unsigned child = 0; child < 8; ++child) {  // at most 16 levels deep
      Key corner = at;
      bool known = true;
      for (std::size_t k = 0; k < 3; ++k) {
        if ((child >> k & 1u) != 0) corner[k] += part;
        known = known && corner[k] < high_[k] && corner[k] + part > low_[k];
      }
      if (!known) continue;
      auto* next = tree_.nodeChildExists(node, child) ? tree_.getNodeChild(node, child)
                                                      : tree_.createNodeChild(node, child);
      fill(next, corner, part, depth + 1, touching);
    }
  }

  const TriangleMesh& mesh_;
  octomap::OcTree& tree_;
  const Key low_, high_;
  const Deadline& deadline_;
  const double res_;
  const float occupied_ = tree_.getClampingThresMaxLog(), free_ = tree_.getClampingThresMinLog();
  std::size_t nodes_ = 0;
  End end_ = End::done;
};

}  // namespace

double mesh_resolution(const TriangleMesh& mesh) {
  double resolution = 0.05;
  const auto voxels = [&] { return ((mesh.upper - mesh.lower) / resolution + Vec3::Constant(2.0)).prod(); };
  while (voxels() > static_cast<double>(kMaxMapVoxels)) resolution *= 2.0;
  return resolution;
}

Result<std::shared_ptr<const octomap::OcTree>> make_octree(const TriangleMesh& mesh, const std::string& name,
                                                           const MeshOctreeOptions& options) {
  const double res = options.resolution.value_or(mesh_resolution(mesh));
  if (!(res >= 1e-3 && res <= 10.0))
    return bad_input(text("a resolution of %g m is outside [0.001, 10] m", res), name, "Give one inside");
  const auto box = options.box.value_or(std::array<Vec3, 2>{mesh.lower, mesh.upper});
  Key low, high;
  double voxels = 1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double from = std::floor(box[0][static_cast<int>(k)] / res - 1e-6);
    const double to = std::max(from + 1.0, std::ceil(box[1][static_cast<int>(k)] / res + 1e-6));
    if (!(from >= -kHalf && to <= kHalf))
      return bad_input(text("the known box leaves the range of an octree of %g m", res), name,
                       "Move the mesh nearer to the origin or use a coarser resolution");
    low[k] = static_cast<int>(from), high[k] = static_cast<int>(to);
    voxels *= to - from;
  }
  if (voxels > static_cast<double>(kMaxMapVoxels))
    return bad_input(text("the known box holds %.3g voxels of %g m, more than the limit of %.0e", voxels, res,
                          static_cast<double>(kMaxMapVoxels)),
                     name, "Crop it or use a coarser resolution");
  auto tree = std::make_shared<octomap::OcTree>(res);
  switch (Voxeliser(mesh, *tree, low, high, options.deadline).run()) {
    case Voxeliser::End::done:
      break;
    case Voxeliser::End::late:
      return out_of_time(options.deadline, "making voxels of the mesh " + name);
    case Voxeliser::End::too_many:
      return bad_input(text("the surface needs more than %.0e nodes of an octree of %g m",
                            static_cast<double>(kMaxOctreeNodes), res),
                       name, "Use a coarser resolution (omniflight_make_test_bed --resolution)");
  }
  tree->updateInnerOccupancy();
  tree->prune();
  bool any = false;
  for (auto leaf = tree->begin_leafs(), end = tree->end_leafs(); leaf != end && !any; ++leaf)
    any = tree->isNodeOccupied(*leaf);
  if (!any)
    return bad_input("no triangle lies in the known box: it would mean that there is no obstacle at all",
                     name, "Give a box that holds part of the mesh");
  return std::shared_ptr<const octomap::OcTree>(std::move(tree));
}

}  // namespace omniflight::planning
