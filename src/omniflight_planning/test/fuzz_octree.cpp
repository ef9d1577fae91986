// Maps of unknown origin: the scan of the bytes, and OctoMap behind it where the scan lets them pass.
#include <octomap/OcTree.h>

#include <iostream>
#include <sstream>

#include "mutated_inputs.hpp"
#include "omniflight_planning/octree_file.hpp"

namespace {
/// As .bt, or as .ot.
std::string a_map(double resolution, int size, bool full) {
  octomap::OcTree tree(resolution);
  for (int x = 0; x < size; ++x)
    for (int y = 0; y < size; ++y)
      tree.updateNode(octomap::point3d(static_cast<float>(resolution * x), static_cast<float>(resolution * y),
                                       static_cast<float>(resolution * ((x * y) % 3))),
                      (x + y) % 2 == 0);
  if (!full) return omniflight::planning::octree_bytes(tree).value();
  std::ostringstream out;
  tree.write(out);
  return out.str();
}
}  // namespace

std::vector<std::string> seeds() {
  std::cerr.rdbuf(nullptr);  // OctoMap tells every file that it reads
  return {a_map(0.05, 4, false), a_map(0.1, 12, false), a_map(0.05, 4, true), a_map(0.1, 12, true)};
}

void feed(std::string_view input) {
  if (const auto tree = omniflight::planning::octree_of(std::string(input), "fuzz"); tree)
    (void)(*tree)->size();
}
