#include "omniflight_allocation/polytope.hpp"

namespace omniflight::allocation {
namespace {

using Polygon = std::vector<Vec3>;
constexpr double kOnFacet =
    1e-7;  // of the body's size: farther from a facet's plane a vertex is none of its corners

// Sutherland-Hodgman: the part of a convex polygon (or segment, or point) inside a half space. Corners within
// tolerance of the plane count as inside, so a plane that only touches cuts nothing off. Most planes cut
// nothing: out is memory for those that do.
void clip(Polygon& polygon, const HalfSpace& h, double tolerance, Polygon& out) {
  const std::size_t n = polygon.size();
  double farthest = -HUGE_VAL;
  for (const Vec3& p : polygon) farthest = std::max(farthest, h.normal.dot(p) - h.offset);
  if (farthest <= tolerance) return;
  out.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % n];
    const double da = h.normal.dot(a) - h.offset, db = h.normal.dot(b) - h.offset;
    const bool in_a = da <= tolerance, in_b = db <= tolerance;
    if (in_a) out.push_back(a);
    if (in_a != in_b && da != db) out.push_back(a + std::clamp(da / (da - db), 0.0, 1.0) * (b - a));
  }
  polygon.swap(out);
}

void add_distinct(std::vector<Vec3>& points, const Vec3& p, double tolerance) {
  for (const Vec3& q : points)
    if ((p - q).norm() <= tolerance) return;
  points.push_back(p);
}

// Drops repeated corners and corners inside an edge.
Polygon corners(const Polygon& polygon, double tolerance) {
  Polygon distinct;
  for (const Vec3& p : polygon) add_distinct(distinct, p, tolerance);
  if (distinct.size() < 3) return distinct;
  Polygon out;
  const std::size_t n = distinct.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 &before = distinct[(i + n - 1) % n], &after = distinct[(i + 1) % n];
    const Vec3 edge = after - before;
    const double off = edge.cross(distinct[i] - before).norm() / std::max(edge.norm(), tolerance);
    if (off > tolerance) out.push_back(distinct[i]);
  }
  return out;
}

Polygon square(const Vec3& centre, const Vec3& a, const Vec3& b, double radius) {
  return {centre + radius * (a + b), centre + radius * (b - a), centre - radius * (a + b),
          centre + radius * (a - b)};
}

std::vector<HalfSpace> merged(const std::vector<HalfSpace>& all, double tolerance, double radius) {
  std::vector<HalfSpace> out;
  for (const HalfSpace& h : all) {
    bool known = false;
    for (HalfSpace& o : out) {
      if ((h.normal - o.normal).norm() * radius > tolerance || std::abs(h.offset - o.offset) > tolerance)
        continue;
      o.offset = std::min(o.offset, h.offset);
      known = true;
      break;
    }
    if (!known) out.push_back(h);
  }
  return out;
}

}  // namespace

Polytope intersect(const Flat& flat, std::vector<HalfSpace> half_spaces, double radius, double tolerance) {
  Polytope body;
  Polygon memory;
  half_spaces = merged(half_spaces, tolerance, radius);
  const double reach = 2.0 * radius;
  if (flat.basis.cols() == 3) {
    for (std::size_t i = 0; i < half_spaces.size(); ++i) {
      const HalfSpace& plane = half_spaces[i];
      const Vec3 a = plane.normal.unitOrthogonal(), b = plane.normal.cross(a);
      const Vec3 foot = flat.origin + (plane.offset - plane.normal.dot(flat.origin)) * plane.normal;
      Polygon polygon = square(foot, a, b, reach);
      for (std::size_t j = 0; j < half_spaces.size() && !polygon.empty(); ++j)
        if (j != i) clip(polygon, half_spaces[j], tolerance, memory);
      polygon = corners(polygon, 4 * tolerance);
      if (polygon.size() < 3) continue;
      body.facets.push_back(plane);
      for (const Vec3& v : polygon) add_distinct(body.vertices, v, 4 * tolerance);
    }
    if (body.facets.size() >= 4)
      body.dimension = 3;
    else
      body.facets.clear(), body.vertices.clear();
    return body;
  }
  Polygon polygon{flat.origin};
  if (flat.basis.cols() == 2) polygon = square(flat.origin, flat.basis.col(0), flat.basis.col(1), reach);
  if (flat.basis.cols() == 1)
    polygon = {flat.origin - reach * flat.basis.col(0), flat.origin + reach * flat.basis.col(0)};
  for (const HalfSpace& h : half_spaces) clip(polygon, h, tolerance, memory);
  body.vertices = corners(polygon, 4 * tolerance);
  body.dimension = static_cast<int>(std::min<std::size_t>(body.vertices.size(), 3)) - 1;
  return body;
}

std::vector<std::array<int, 3>> triangles(const Polytope& body) {
  std::vector<std::array<int, 3>> out;
  if (body.dimension < 2) return out;
  double size = 0;
  for (const Vec3& v : body.vertices) size = std::max(size, v.norm());
  const auto fan = [&](const std::vector<int>& corners, const Vec3& normal) {
    Vec3 middle = Vec3::Zero();
    for (const int i : corners) middle += body.vertices[static_cast<std::size_t>(i)];
    middle /= static_cast<double>(corners.size());
    const Vec3 a = normal.unitOrthogonal(), b = normal.cross(a);
    std::vector<std::pair<double, int>> around;
    for (const int i : corners) {
      const Vec3 r = body.vertices[static_cast<std::size_t>(i)] - middle;
      around.emplace_back(std::atan2(b.dot(r), a.dot(r)), i);
    }
    std::sort(around.begin(), around.end());
    for (std::size_t k = 2; k < around.size(); ++k)
      out.push_back({around[0].second, around[k - 1].second, around[k].second});
  };
  std::vector<int> corners;
  if (body.dimension == 2) {
    for (std::size_t i = 0; i < body.vertices.size(); ++i) corners.push_back(static_cast<int>(i));
    const Vec3 along = body.vertices[1] - body.vertices[0];
    Vec3 normal = Vec3::Zero();
    for (const Vec3& v : body.vertices)
      if (const Vec3 n = along.cross(v - body.vertices[0]); n.norm() > normal.norm()) normal = n;
    fan(corners, normal.normalized());
    return out;
  }
  for (const HalfSpace& facet : body.facets) {
    corners.clear();
    for (std::size_t i = 0; i < body.vertices.size(); ++i)
      if (std::abs(facet.normal.dot(body.vertices[i]) - facet.offset) < kOnFacet * size)
        corners.push_back(static_cast<int>(i));
    if (corners.size() >= 3) fan(corners, facet.normal);
  }
  return out;
}

SetMeasures measure(const Polytope& body) {
  SetMeasures m;
  m.dimension = body.dimension;
  m.facets = static_cast<int>(body.facets.size());
  m.vertices = static_cast<int>(body.vertices.size());
  if (body.empty()) return m;
  m.d_min_vertex = HUGE_VAL;
  for (const Vec3& v : body.vertices) {
    m.d_min_vertex = std::min(m.d_min_vertex, v.norm());
    m.d_max = std::max(m.d_max, v.norm());
  }
  if (body.dimension < 3) return m;
  double nearest = HUGE_VAL;
  for (const HalfSpace& h : body.facets) nearest = std::min(nearest, h.offset);
  m.holds_zero = nearest >= -1e-12 * m.d_max;
  m.d_min_surface = std::max(nearest, 0.0);
  if (m.holds_zero && m.d_max > 0) {
    m.uniformity_surface = m.d_min_surface / m.d_max;
    m.uniformity_vertex = m.d_min_vertex / m.d_max;
  }
  return m;
}

}  // namespace omniflight::allocation
