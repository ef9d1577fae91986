// Maps of unknown origin: the scan of the bytes, and OctoMap behind it where the scan lets them pass.
#include <octomap/OcTree.h>

#include <iostream>
#include <sstream>

#include "mutated_inputs.hpp"
#include "omniflight_planning/octree_file.hpp"

namespace {
std::string a_map(double resolution, int size) {
  octomap::OcTree tree(resolution);
  for (int x = 0; x < size; ++x)
    for (int y = 0; y < size; ++y)
      tree.updateNode(octomap::point3d(static_cast<float>(resolution * x), static_cast<float>(resolution * y),
                                       static_cast<float>(resolution * ((x * y) % 3))),
                      (x + y) % 2 == 0);
  return omniflight::planning::octree_bytes(tree).value();
}
}  // namespace

std::vector<std::string> seeds() {
  std::cerr.rdbuf(nullptr);  // OctoMap tells every file that it reads
  return {a_map(0.05, 4), a_map(0.1, 12)};
}

void feed(std::string_view input) {
  if (!omniflight::planning::scan_octree(input, "fuzz.bt")) return;
  octomap::OcTree tree(0.1);
  std::istringstream stream{std::string(input)};
  if (tree.readBinary(stream)) (void)tree.size();
}
