#include "mesh_scan.hpp"

#include <cstring>
#include <filesystem>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"
#include "text.hpp"
#include "tokens.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;  // bytes
constexpr int kMostCorners = 1000;                         // of one face

std::string line_of(const std::string& name, std::size_t line) { return name + ":" + std::to_string(line); }

std::string ending(const std::filesystem::path& path) {
  std::string out = path.extension().string();
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

bool binary_stl(std::string_view bytes, std::uint32_t& triangles) {
  if (bytes.size() < kStlHeader) return false;
  std::memcpy(&triangles, bytes.data() + kStlHeader - sizeof triangles, sizeof triangles);
  return bytes.size() == kStlHeader + kStlTriangle * static_cast<std::uint64_t>(triangles);
}

Status too_many(const std::string& name) {
  return refuse_mesh(text("more than %zu triangles", kMaxMeshTriangles), name);
}

/// Corners of an f line, each v, v/t, v//n or v/t/n, counted from 1 or back from the last with negative ones.
Status scan_face(Tokens words, std::size_t vertices, const std::string& where, std::size_t& triangles) {
  int corners = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++corners) {
    long long index = 0;
    const std::string_view first = word.substr(0, word.find('/'));
    const auto count = static_cast<long long>(vertices);
    if (!parse_number(first, index) || index == 0 || index > count || -index > count)
      return refuse_mesh("corner " + files::shown(word) + " of the face is none of the " +
                             std::to_string(vertices) + " vertices before it",
                         where);
    if (corners >= kMostCorners) return refuse_mesh("a face of more than 1000 corners", where);
  }
  if (corners < 3) return refuse_mesh("a face of fewer than three corners", where);
  triangles += static_cast<std::size_t>(corners - 2);
  return {};
}

}  // namespace

Failure refuse_mesh(const std::string& why, const std::string& where) {
  return bad_input(why, where, "Export the mesh again as a binary .stl of triangles, or with fewer of them");
}

Status scan_stl(std::string_view bytes, const std::string& name) {
  std::uint32_t count = 0;
  if (binary_stl(bytes, count)) {
    if (count == 0) return refuse_mesh("the file has no triangle", name);
    return count > kMaxMeshTriangles ? too_many(name) : Status{};
  }
  if (!bytes.starts_with("solid"))
    return refuse_mesh(
        text("neither an ASCII .stl (it does not begin with 'solid') nor a binary one: %zu bytes are "
             "not the 84 + 50 a triangle of the %u that its header tells",
             bytes.size(), bytes.size() < kStlHeader ? 0u : count),
        name);
  Lines lines(bytes);
  std::string_view line;
  lines.next(line);
  const std::string_view pattern[] = {"facet",  "normal", "#", "#", "#",      "outer",   "loop",
                                      "vertex", "#",      "#", "#", "vertex", "#",       "#",
                                      "#",      "vertex", "#", "#", "#",      "endloop", "endfacet"};
  Tokens words(lines.rest());
  std::size_t triangles = 0;
  for (std::string_view word = words.next(); word != "endsolid"; word = words.next()) {
    ++triangles;
    for (const std::string_view& expected : pattern) {
      if (expected == "#" ? !parse_finite(word) : word != expected)
        return refuse_mesh(text("triangle %zu: ", triangles) + files::shown(word) + " stands where " +
                               (expected == "#" ? "a finite number" : "'" + std::string(expected) + "'") +
                               " is due",
                           name);
      if (expected != "endfacet") word = words.next();
    }
    if (triangles > kMaxMeshTriangles) return too_many(name);
  }
  return triangles == 0 ? Status(refuse_mesh("the file has no triangle", name)) : Status{};
}

Status scan_obj(std::string_view bytes, const std::string& name) {
  // what else there is (curves, surfaces, continued lines) is not a mesh of faces
  constexpr std::string_view kIgnored[] = {"vn", "vt", "g", "o", "s", "usemtl", "mtllib", "l", "p"};
  Lines lines(bytes);
  std::string_view line;
  std::size_t vertices = 0, triangles = 0;
  while (lines.next(line)) {
    Tokens words(line);
    const std::string_view key = words.next();
    const std::string where = line_of(name, lines.number());
    if (key.empty() || key.front() == '#') continue;
    if (line.find('\\') != std::string_view::npos && key != "mtllib")
      return refuse_mesh("a line that is continued on the next", where);
    if (key == "v") {
      int numbers = 0;
      for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++numbers)
        if (!parse_finite(word) || numbers >= 7)
          return refuse_mesh(files::shown(word) + " is no coordinate of a vertex", where);
      if (numbers < 3) return refuse_mesh("a vertex of fewer than three coordinates", where);
      ++vertices;
    } else if (key == "f") {
      if (auto ok = scan_face(words, vertices, where, triangles); !ok) return ok;
      if (triangles > kMaxMeshTriangles) return too_many(name);
    } else if (std::find(std::begin(kIgnored), std::end(kIgnored), key) == std::end(kIgnored)) {
      return refuse_mesh("the line begins with " + files::shown(key) + ", which is not read", where);
    }
  }
  return triangles == 0 ? Status(refuse_mesh("the file has no face", name)) : Status{};
}

bool is_mesh(const std::filesystem::path& path) {
  const std::string end = ending(path);
  return end == ".stl" || end == ".obj" || end == ".ply" || end == ".dae";
}

Result<MeshHeader> scan_mesh(std::string_view bytes, const std::string& name) {
  MeshHeader header;
  const std::string end = ending(name);
  if (bytes.size() > kMaxMeshBytes)
    return refuse_mesh(text("%zu bytes, more than the limit of %zu", bytes.size(), kMaxMeshBytes), name);
  Status ok;
  if (end == ".stl") {
    ok = scan_stl(bytes, name);
  } else if (end == ".obj") {
    header.format = MeshFormat::obj;
    ok = scan_obj(bytes, name);
  } else if (end == ".ply") {
    header.format = MeshFormat::ply;
    ok = scan_ply(bytes, name);
  } else if (end == ".dae") {
    header.format = MeshFormat::dae;
    ok = scan_dae(bytes, name, header);
  } else {
    return bad_input("the ending " + files::shown(end) + " is none of .stl, .obj, .ply and .dae", name,
                     "Rename or convert the mesh");
  }
  if (!ok) return Failure(ok.error());
  return header;
}

}  // namespace omniflight::planning
