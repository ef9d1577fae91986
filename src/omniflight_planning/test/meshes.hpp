// Meshes that tests make themselves, and the files that hold them.
#pragma once

#include <cstring>
#include <string>

#include "omniflight_planning/mesh.hpp"

namespace omniflight::planning {

/// Appends a closed axis-aligned box.
inline void add_box(TriangleMesh& mesh, const Vec3& low, const Vec3& high) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                               i & 4 ? high.z() : low.z());
  constexpr std::uint32_t kFaces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const auto& f : kFaces) mesh.triangles.push_back({first + f[0], first + f[1], first + f[2]});
  mesh.move(Vec3::Zero());  // measures its box
}

/// A room of 4 x 3 x 2.4 m with closed walls of 0.1 m around it, cut in two by a wall at x from 0 to 0.1 m
/// with a window of this width (y) and height (z) about its middle.
inline TriangleMesh window_room(double width, double height) {
  TriangleMesh mesh;
  add_box(mesh, Vec3(-2.1, -1.6, -0.1), Vec3(-2, 1.6, 2.5));
  add_box(mesh, Vec3(2, -1.6, -0.1), Vec3(2.1, 1.6, 2.5));
  add_box(mesh, Vec3(-2.1, -1.6, -0.1), Vec3(2.1, -1.5, 2.5));
  add_box(mesh, Vec3(-2.1, 1.5, -0.1), Vec3(2.1, 1.6, 2.5));
  add_box(mesh, Vec3(-2.1, -1.6, -0.1), Vec3(2.1, 1.6, 0));
  add_box(mesh, Vec3(-2.1, -1.6, 2.4), Vec3(2.1, 1.6, 2.5));
  const double w = 0.5 * width, h = 0.5 * height, z = 1.2;
  add_box(mesh, Vec3(0, -1.5, 0), Vec3(0.1, -w, 2.4));
  add_box(mesh, Vec3(0, w, 0), Vec3(0.1, 1.5, 2.4));
  if (h < z) {
    add_box(mesh, Vec3(0, -w, 0), Vec3(0.1, w, z - h));
    add_box(mesh, Vec3(0, -w, z + h), Vec3(0.1, w, 2.4));
  }
  return mesh;
}

inline std::string binary_stl_of(const TriangleMesh& mesh) {
  std::string out(84, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(out.data() + 80, &count, sizeof count);
  const auto put = [&out](const Vec3& v) {
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<float>(v[k]);
      out.append(reinterpret_cast<const char*>(&x), sizeof x);
    }
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    put(Vec3::Zero());
    for (const Vec3& p : mesh.corners(i)) put(p);
    out.append(2, '\0');
  }
  return out;
}

inline std::string number_text(double x) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.9g", x);
  return buffer;
}
inline std::string place_text(const Vec3& p) {
  return number_text(p.x()) + " " + number_text(p.y()) + " " + number_text(p.z());
}

inline std::string ascii_stl_of(const TriangleMesh& mesh) {
  std::string out = "solid made by a test\n";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    out += "facet normal 0 0 0\n outer loop\n";
    for (const Vec3& p : mesh.corners(i)) out += "  vertex " + place_text(p) + "\n";
    out += " endloop\nendfacet\n";
  }
  return out + "endsolid made by a test\n";
}

inline std::string obj_of(const TriangleMesh& mesh) {
  std::string out = "# made by a test\nmtllib missing.mtl\n";
  for (const Vec3& p : mesh.vertices) out += "v " + place_text(p) + "\n";
  for (const auto& t : mesh.triangles)
    out += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) +
           "\n";
  return out;
}

inline std::string ascii_ply_of(const TriangleMesh& mesh) {
  std::string out = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.vertices.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                    std::to_string(mesh.triangles.size()) +
                    "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& p : mesh.vertices) out += place_text(p) + "\n";
  for (const auto& t : mesh.triangles)
    out += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  return out;
}

inline std::string dae_of(
    const TriangleMesh& mesh, const std::string& unit = "<unit meter=\"1\" name=\"meter\"/>",
    const std::string& nodes = "<node id=\"n\"><instance_geometry url=\"#g\"/></node>") {
  std::string places, indices;
  for (const Vec3& p : mesh.vertices) places += place_text(p) + " ";
  for (const auto& t : mesh.triangles)
    for (const auto i : t) indices += std::to_string(i) + " ";
  const std::string count = std::to_string(mesh.vertices.size());
  return "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\">\n"
         "<asset>" +
         unit +
         "<up_axis>Z_UP</up_axis></asset>\n<library_geometries><geometry id=\"g\"><mesh>\n<source id=\"p\">"
         "<float_array id=\"a\" count=\"" +
         std::to_string(3 * mesh.vertices.size()) + "\">" + places +
         "</float_array><technique_common><accessor source=\"#a\" count=\"" + count +
         "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param "
         "name=\"Z\" "
         "type=\"float\"/></accessor></technique_common></source>\n<vertices id=\"v\"><input "
         "semantic=\"POSITION\" "
         "source=\"#p\"/></vertices>\n<triangles count=\"" +
         std::to_string(mesh.triangles.size()) +
         "\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" + indices +
         "</p></triangles></mesh></geometry></library_geometries>\n<library_visual_scenes><visual_scene "
         "id=\"s\">" +
         nodes +
         "</visual_scene></library_visual_scenes>\n<scene><instance_visual_scene "
         "url=\"#s\"/></scene></COLLADA>\n";
}

}  // namespace omniflight::planning
