#include "convex_parts.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace omniflight::planning {
namespace {

constexpr double kFlatShare = 1e-9;  // of the span: points this far beyond a plane count as on it

using MeshEdge = std::pair<std::uint32_t, std::uint32_t>;

/// The three edges of a triangle, each from its lower to its higher vertex.
std::array<MeshEdge, 3> edges_of(const std::array<std::uint32_t, 3>& t) {
  return {std::minmax(t[0], t[1]), std::minmax(t[1], t[2]), std::minmax(t[2], t[0])};
}

/// Of each triangle the lowest one of its component.
std::vector<std::size_t> components_of(const TriangleMesh& mesh) {
  std::map<MeshEdge, std::vector<std::size_t>> sharing;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const MeshEdge& edge : edges_of(mesh.triangles[i])) sharing[edge].push_back(i);
  std::vector<std::size_t> root(mesh.triangles.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& [edge, triangles] : sharing) {
    if (triangles.size() != 2) continue;
    const std::size_t a = find(triangles[0]), b = find(triangles[1]);
    root[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = find(i);
  return root;
}

bool is_closed(const TriangleMesh& mesh, const std::vector<std::size_t>& component) {
  std::map<MeshEdge, int> count;
  for (const std::size_t i : component)
    for (const MeshEdge& edge : edges_of(mesh.triangles[i])) ++count[edge];
  return std::all_of(count.begin(), count.end(), [](const auto& one) { return one.second == 2; });
}

bool is_convex(const ConvexPart& part) {
  Vec3 low = part.points.front(), high = low;
  for (const Vec3& p : part.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double slack = kFlatShare * (high - low).maxCoeff();
  for (const Triangle& t : part.surface) {
    const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
    const double area = n.norm();
    if (area <= slack * slack) return false;
    double least = 0.0, most = 0.0;
    for (const Vec3& p : part.points) {
      const double beyond = n.dot(p - t[0]) / area;
      least = std::min(least, beyond), most = std::max(most, beyond);
    }
    if (least < -slack && most > slack) return false;
  }
  return true;
}

}  // namespace

bool ConvexPart::holds(const Vec3& p) const {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& point : points) middle += point / static_cast<double>(points.size());
  return std::all_of(surface.begin(), surface.end(), [&](const Triangle& t) {
    const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
    return n.dot(p - t[0]) * n.dot(middle - t[0]) > 0.0;
  });
}

MeshParts parts_of(const TriangleMesh& mesh) {
  const auto root = components_of(mesh);
  std::map<std::size_t, std::vector<std::size_t>> components;
  for (std::size_t i = 0; i < root.size(); ++i) components[root[i]].push_back(i);
  MeshParts out;
  for (const auto& [first, component] : components) {
    std::vector<std::uint32_t> vertices;
    ConvexPart part;
    for (const std::size_t i : component) {
      part.surface.push_back(mesh.corners(i));
      vertices.insert(vertices.end(), mesh.triangles[i].begin(), mesh.triangles[i].end());
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const auto v : vertices) part.points.push_back(mesh.vertices[v]);
    if (part.points.size() <= kMostPoints && is_closed(mesh, component) && is_convex(part))
      out.solids.push_back(std::move(part));
    else
      out.triangles.insert(out.triangles.end(), part.surface.begin(), part.surface.end());
  }
  return out;
}

}  // namespace omniflight::planning
