#include "omniflight_planning/octree_file.hpp"

#include <octomap/OcTree.h>

#include <sstream>

#include "octree_advice.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"

namespace omniflight::planning {
namespace {}  // namespace

Result<std::shared_ptr<const octomap::OcTree>> octree_of(std::string bytes, const std::string& name,
                                                         const Deadline& deadline) {
  if (is_mesh(name)) {
    const auto mesh = mesh_of(bytes, name, {.deadline = deadline});
    if (!mesh) return Failure(mesh.error());
    return make_octree(*mesh, name, {.deadline = deadline});
  }
  const auto header = scan_octree(bytes, name);
  if (!header) return Failure(header.error());
  auto tree = std::make_shared<octomap::OcTree>(header->resolution);
  std::istringstream stream(std::move(bytes));
  stream.seekg(static_cast<std::streamoff>(header->data_begin));
  // OctoMap's own reader of whole files prints to the terminal and trusts the header; the nodes are all that
  // is left.
  if (!(header->full ? tree->readData(stream) : tree->readBinaryData(stream)) ||
      tree->size() != header->nodes)
    return bad_input("OctoMap could not read the map", name, kRemakeMap);
  if (header->full) {  // what inner nodes say may be anything, and only occupied or not is asked
    tree->updateInnerOccupancy();
    tree->toMaxLikelihood();
    tree->prune();
  }
  return tree;
}

Result<OctreeFile> read_octree(const std::filesystem::path& path) {
  auto bytes = files::read_file(path, kMaxOctreeBytes);
  if (!bytes) return Failure(bytes.error());
  OctreeFile out;
  out.sha256 = files::sha256_hex(*bytes);
  auto tree = octree_of(std::move(*bytes), path.string());
  if (!tree) return Failure(tree.error());
  out.tree = std::move(*tree);
  return out;
}

Result<std::string> octree_bytes(const octomap::OcTree& tree) {
  std::ostringstream stream;
  octomap::OcTree copy(tree);
  copy.toMaxLikelihood();
  copy.prune();
  stream << "# Octomap OcTree binary file\nid OcTree\nsize " << copy.size() << "\nres "
         << copy.getResolution() << "\ndata\n";
  if (!copy.writeBinaryData(stream)) return fail(ErrorCode::internal, "OctoMap could not write the map");
  return stream.str();
}

}  // namespace omniflight::planning
