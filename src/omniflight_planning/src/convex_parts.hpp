// The closed convex parts that a triangle mesh consists of.
#pragma once

#include <vector>

#include "omniflight_planning/mesh.hpp"
#include "triangle.hpp"

namespace omniflight::planning {

/// A convex polyhedron: the hull of its points, of which these triangles are the whole surface.
struct ConvexPart {
  std::vector<Vec3> points;         ///< m
  std::vector<Triangle> surface;    ///< m
  bool holds(const Vec3& p) const;  ///< strictly inside
};

struct MeshParts {
  std::vector<ConvexPart> solids;
  std::vector<Triangle> triangles;  ///< m, of everything else
};

/// Components connected over edges that exactly two triangles share. One is a solid where every edge of it
/// has two triangles, every triangle has all its points on one side, and there are no more than kMostPoints.
MeshParts parts_of(const TriangleMesh& mesh);

inline constexpr std::size_t kMostPoints = 64;  ///< of a solid

}  // namespace omniflight::planning
