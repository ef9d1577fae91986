// omniflight_make_test_bed IN.yaml OUT.bt: voxelises a test bed into an OctoMap file.
#include <octomap/OcTree.h>

#include <cstdio>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/test_bed.hpp"

namespace op = omniflight::planning;

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs(
        "usage: omniflight_make_test_bed IN.yaml OUT.bt\n"
        "example: omniflight_make_test_bed configs/test_beds/pyramid.yaml configs/test_beds/pyramid.bt\n",
        stderr);
    return 4;
  }
  const auto refuse = [](const omniflight::Error& error) {
    std::fprintf(stderr, "omniflight_make_test_bed: %s\n", error.text().c_str());
    return static_cast<int>(error.code);
  };
  const auto bed = op::load_test_bed(argv[1]);
  if (!bed) return refuse(bed.error());
  const auto tree = op::make_octree(*bed);
  if (!tree) return refuse(tree.error());
  const auto bytes = op::octree_bytes(**tree);
  if (!bytes) return refuse(bytes.error());
  if (const auto scan = op::scan_octree(*bytes, argv[2]); !scan) return refuse(scan.error());
  if (auto ok = omniflight::files::write_file_atomic(argv[2], *bytes); !ok) return refuse(ok.error());
  std::printf("%s: %zu nodes, %zu bytes, resolution %g m\n", argv[2], (*tree)->size(), bytes->size(),
              bed->resolution);
  return 0;
}
