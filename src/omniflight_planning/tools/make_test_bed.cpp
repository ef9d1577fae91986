// omniflight_make_test_bed IN OUT.bt: makes an OctoMap file of a test bed's YAML or of a mesh.
#include <octomap/OcTree.h>

#include <charconv>
#include <cstdio>
#include <cstring>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/test_bed.hpp"

namespace op = omniflight::planning;

namespace {

constexpr const char* kUsage =
    "usage: omniflight_make_test_bed IN OUT.bt [options]\n"
    "IN is a test bed's YAML or a mesh (.stl, .obj, .ply, .dae). Of a mesh every voxel that a triangle "
    "touches is\n"
    "occupied, and every other one of the known box is free.\n"
    "options, of meshes only:\n"
    "  --resolution M      edge of a voxel [m]; default 0.05, doubled until the box holds 10 million voxels "
    "at most\n"
    "  --scale S           m a unit of the file; default what a .dae tells, else 1 (0.001: millimetres)\n"
    "  --box X Y Z X Y Z   lower and upper corner of the known box [m]; default the box of the mesh. "
    "Everything\n"
    "                      outside of it counts as an obstacle\n"
    "example: omniflight_make_test_bed configs/test_beds/pyramid.yaml configs/test_beds/pyramid.bt\n"
    "example: omniflight_make_test_bed hall.stl hall.bt --scale 0.001 --box -3 -3 0 3 3 4\n";

using Tree = std::shared_ptr<const octomap::OcTree>;

bool number(const char* word, double& value) {
  const auto [end, error] = std::from_chars(word, word + std::strlen(word), value);
  return error == std::errc{} && *end == '\0' && value > -1e9 && value < 1e9;
}

struct Options {
  op::MeshOptions mesh;
  op::MeshOctreeOptions octree;
};

/// False where an option is unknown, or its numbers are missing or no numbers.
bool read_options(int argc, char** argv, Options& out) {
  for (int i = 3; i < argc; ++i) {
    const std::string word = argv[i];
    double value = 0.0;
    if ((word == "--resolution" || word == "--scale") && i + 1 < argc) {
      if (!number(argv[++i], value) || value <= 0.0) return false;
      (word == "--scale" ? out.mesh.scale : out.octree.resolution) = value;
    } else if (word == "--box" && i + 6 < argc) {
      std::array<omniflight::Vec3, 2> box;
      for (int k = 0; k < 6; ++k)
        if (!number(argv[++i], box[static_cast<std::size_t>(k / 3)][k % 3])) return false;
      if ((box[0].array() >= box[1].array()).any()) return false;
      out.octree.box = box;
    } else {
      return false;
    }
  }
  return true;
}

omniflight::Result<Tree> tree_of(const std::string& in, const Options& options) {
  if (op::is_mesh(in)) {
    const auto mesh = op::read_mesh(in, options.mesh);
    if (!mesh) return omniflight::Failure(mesh.error());
    return op::make_octree(*mesh, in, options.octree);
  }
  const auto bed = op::load_test_bed(in);
  if (!bed) return omniflight::Failure(bed.error());
  return op::make_octree(*bed);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) return std::fputs(kUsage, stdout) < 0;
  if (argc < 3 || !read_options(argc, argv, options) || (argc > 3 && !op::is_mesh(argv[1]))) {
    std::fputs(kUsage, stderr);
    return 4;
  }
  const auto refuse = [](const omniflight::Error& error) {
    std::fprintf(stderr, "omniflight_make_test_bed: %s\n", error.text().c_str());
    return static_cast<int>(error.code);
  };
  const auto tree = tree_of(argv[1], options);
  if (!tree) return refuse(tree.error());
  const auto bytes = op::octree_bytes(**tree);
  if (!bytes) return refuse(bytes.error());
  if (const auto scan = op::scan_octree(*bytes, argv[2]); !scan) return refuse(scan.error());
  if (auto ok = omniflight::files::write_file_atomic(argv[2], *bytes); !ok) return refuse(ok.error());
  std::printf("%s: %zu nodes, %zu bytes, resolution %g m\n", argv[2], (*tree)->size(), bytes->size(),
              (*tree)->getResolution());
  return 0;
}
