#include "omniflight_planning/map_solids.hpp"

#include <octomap/OcTree.h>

#include "omniflight_planning/octree_file.hpp"

namespace omniflight::planning {
namespace {

std::vector<Primitive> boxes_of(const octomap::OcTree& tree, std::size_t most) {
  std::vector<Primitive> out;
  for (unsigned depth = tree.getTreeDepth(); depth > 0; --depth) {
    out.clear();
    for (auto leaf = tree.begin_leafs(static_cast<unsigned char>(depth)), end = tree.end_leafs();
         leaf != end && out.size() <= most; ++leaf)
      if (tree.isNodeOccupied(*leaf))
        out.push_back({.kind = Primitive::Kind::box,
                       .name = "voxels",
                       .a = Vec3(leaf.getX(), leaf.getY(), leaf.getZ()),
                       .b = Vec3::Constant(leaf.getSize())});
    if (out.size() <= most) break;
  }
  return out;
}

}  // namespace

Result<MapSolids> map_solids(const Mission& mission, std::size_t most) {
  MapSolids out;
  if (!mission.description.empty()) {
    auto bed = load_test_bed(mission.description);
    if (!bed) return Failure(bed.error());
    out.solids = std::move(bed->primitives);
  } else {
    const auto file = read_octree(mission.test_bed);
    if (!file) return Failure(file.error());
    out.solids = boxes_of(*file->tree, most);
  }
  const auto& zones = mission.zones.keep_out;
  out.solids.insert(out.solids.end(), zones.begin(), zones.end());
  out.zones = zones.size();
  return out;
}

}  // namespace omniflight::planning
