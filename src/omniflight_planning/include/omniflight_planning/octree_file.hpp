// Maps of unknown origin: OctoMap's .bt and .ot files, scanned without recursion before OctoMap itself reads
// a byte, and meshes (mesh.hpp), whose surface is made an octree.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "omniflight_core/result.hpp"
#include "omniflight_planning/deadline.hpp"

namespace octomap {
class OcTree;
}

namespace omniflight::planning {

/// What the scan of a file found.
struct OctreeHeader {
  bool full = false;           ///< .ot: every node has its log-odds; .bt: free, occupied or unknown
  std::uint64_t nodes = 0;     ///< inner nodes and leaves
  double resolution = 0.0;     ///< m
  std::size_t data_begin = 0;  ///< offset of the first node byte
  bool has_occupied = false;
  /// Voxels of the finest level that the box of known space spans: what a distance field of it holds.
  std::uint64_t voxels = 0;
};

// A map within these limits takes less than 100 MB and is known to be within them before anything is
// allocated.
inline constexpr std::uint64_t kMaxOctreeNodes = 1'000'000;  ///< 41 bytes each (OctoMap 1.9)
inline constexpr std::size_t kMaxOctreeBytes = 16u << 20;    ///< of a file
inline constexpr std::uint64_t kMaxMapVoxels = 10'000'000;   ///< 5 bytes each: a distance and a flag

/// Checks a whole .bt or .ot file held in memory, told apart by the first line: header of at most 64 kB, id
/// OcTree, resolution in [1e-3, 10] m, at most 16 levels, node count equal to the header's, nothing missing
/// and nothing left over, finite log-odds, at least one occupied node, no more nodes and voxels than the
/// limits above. `name` appears in errors.
Result<OctreeHeader> scan_octree(std::string_view bytes, const std::string& name);

struct OctreeFile {
  std::shared_ptr<const octomap::OcTree> tree;
  std::string sha256;  ///< of the file's bytes
};

/// The tree of a whole .bt or .ot file held in memory, handed out only when everything agrees; that of an .ot
/// file in maximum-likelihood form, a voxel of probability 0.5 (log-odds 0) or more being occupied, as
/// OctoMap has it by default; that of a mesh in the resolution of mesh_resolution(), its box being known.
/// `name` appears in errors, and its ending tells a mesh (is_mesh).
Result<std::shared_ptr<const octomap::OcTree>> octree_of(std::string bytes, const std::string& name,
                                                         const Deadline& deadline = {});

/// The same of a file of at most kMaxOctreeBytes.
Result<OctreeFile> read_octree(const std::filesystem::path& path);

/// The .bt bytes of a tree (maximum-likelihood form, pruned).
Result<std::string> octree_bytes(const octomap::OcTree& tree);

}  // namespace omniflight::planning
