// Triangle meshes of unknown origin (.stl, .obj, .ply, .dae), and octrees that hold their surface.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_planning/deadline.hpp"

namespace octomap {
class OcTree;
}

namespace omniflight::planning {

/// A surface of triangles; closed or not. Vertices with the same coordinates are one.
struct TriangleMesh {
  std::vector<Vec3> vertices;                           ///< m, in the frame of the file
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< of vertices; there is at least one
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();      ///< m, the box of the vertices in use

  std::array<Vec3, 3> corners(std::size_t triangle) const {
    const auto& t = triangles[triangle];
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
  }
  Vec3 mean_vertex() const;   ///< m
  void move(const Vec3& by);  ///< m
  void scale(double factor);  ///< about the origin of its frame
};

// Known before the library that reads meshes sees a byte, so that no file takes much more than 200 MB.
inline constexpr std::size_t kMaxMeshBytes = 16u << 20;
inline constexpr std::size_t kMaxMeshTriangles = 500'000;
inline constexpr double kMaxMeshSpan = 1000.0;  ///< m
inline constexpr double kMinMeshSpan = 1e-3;    ///< m, of the longest side

/// The ending tells: .stl, .obj, .ply or .dae, in any case.
bool is_mesh(const std::filesystem::path& path);

struct MeshOptions {
  /// m a unit of the file. Nothing: what a .dae tells, 1 for the other formats, which tell none.
  std::optional<double> scale = {};
  bool any_span = false;  ///< do not judge the unit by the span of the mesh
  Deadline deadline = {};
};

/// Reads a whole file that is held in memory. Refused before it is parsed: what is too large, lies about its
/// counts, points outside of its vertices, nests or repeats too much, and XML with declarations. Refused
/// afterwards: coordinates that are not finite, faces that cannot be made triangles, and meshes that span
/// more than kMaxMeshSpan or less than kMinMeshSpan, which are in another unit. Other files that it names
/// (materials, textures) are not opened. `name` appears in errors, and its ending tells the format.
Result<TriangleMesh> mesh_of(const std::string& bytes, const std::string& name,
                             const MeshOptions& options = {});

/// The same of a file of at most kMaxMeshBytes.
Result<TriangleMesh> read_mesh(const std::filesystem::path& path, const MeshOptions& options = {});

struct MeshOctreeOptions {
  std::optional<double> resolution = {};  ///< m, in [1e-3, 10]; nothing: see mesh_resolution()
  /// m, corners of the box that is known, widened to whole voxels; nothing: the box of the mesh. Everything
  /// outside of it counts as an obstacle.
  std::optional<std::array<Vec3, 2>> box = {};
  Deadline deadline = {};
};

/// 0.05 m, doubled until the mesh's box holds no more than kMaxMapVoxels [m].
double mesh_resolution(const TriangleMesh& mesh);

/// Occupied: every voxel that a triangle touches (separating axes; rounding counts as contact). Free: every
/// other one of the known box, the inside of closed surfaces included, where nothing gets without passing the
/// surface. Whatever keeps clear of the voxels therefore keeps clear of the mesh.
Result<std::shared_ptr<const octomap::OcTree>> make_octree(const TriangleMesh& mesh, const std::string& name,
                                                           const MeshOctreeOptions& options = {});

}  // namespace omniflight::planning
