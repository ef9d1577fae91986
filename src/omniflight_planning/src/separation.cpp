#include "separation.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr int kMostDirections = 40;
constexpr double kDistanceShare = 0.1;     // of the distance
constexpr double kGapExact = 1e-6;         // m
constexpr double kNoDistance = 1e-12;      // m
constexpr double kFlatTetrahedron = 1e-9;  // m

/// The index of the point with the least n . p, and that product.
int lowest_point(const PointsView& points, const Vec3& n, double& least) {
  int found = 0;
  least = HUGE_VAL;
  for (int i = 0; i < points.count; ++i) {
    const double along = n.x() * points.x[i] + n.y() * points.y[i] + n.z() * points.z[i];
    if (along < least) least = along, found = i;
  }
  return found;
}

/// Up to four points of the difference of the hulls.
struct GapSimplex {
  Vec3 p[4];
  int count = 0;
};

/// The nearest point to the origin of a segment, a triangle or a tetrahedron, which become the face that it
/// lies on (Ericson, Real-Time Collision Detection, 5.1.2, 5.1.5 and 5.1.6).
Vec3 nearest_of_segment(GapSimplex& s) {
  const Vec3 along = s.p[1] - s.p[0];
  const double square = along.squaredNorm(), t = square > 0.0 ? -s.p[0].dot(along) / square : 0.0;
  if (t <= 0.0) {
    s.count = 1;
    return s.p[0];
  }
  if (t >= 1.0) {
    s.p[0] = s.p[1], s.count = 1;
    return s.p[0];
  }
  return s.p[0] + t * along;
}

Vec3 nearest_of_triangle(GapSimplex& s) {
  const Vec3 a = s.p[0], b = s.p[1], c = s.p[2], ab = b - a, ac = c - a;
  const auto keep = [&s](const Vec3& p) {
    s.p[0] = p, s.count = 1;
    return p;
  };
  const auto keep_edge = [&s](const Vec3& p, const Vec3& q, double t) -> Vec3 {
    s.p[0] = p, s.p[1] = q, s.count = 2;
    return p + t * (q - p);
  };
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0.0 && d2 <= 0.0) return keep(a);
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0.0 && d4 <= d3) return keep(b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return keep_edge(a, b, d1 > d3 ? d1 / (d1 - d3) : 0.0);
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0.0 && d5 <= d6) return keep(c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return keep_edge(a, c, d2 > d6 ? d2 / (d2 - d6) : 0.0);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double all = (d4 - d3) + (d5 - d6);
    return keep_edge(b, c, all > 0.0 ? (d4 - d3) / all : 0.0);
  }
  const double inverse = 1.0 / (va + vb + vc);
  return a + ab * (vb * inverse) + ac * (vc * inverse);
}

Vec3 nearest_of_tetrahedron(GapSimplex& s) {
  constexpr int kFaces[4][4] = {
      {0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};  // and what is opposite
  GapSimplex best;
  Vec3 found = Vec3::Zero();
  double least = HUGE_VAL;
  for (const auto& f : kFaces) {
    const Vec3 &a = s.p[f[0]], &b = s.p[f[1]], &c = s.p[f[2]];
    const Vec3 n = (b - a).cross(c - a);
    const double origin = -n.dot(a), fourth = n.dot(s.p[f[3]] - a);
    // on the inner side, which a flat tetrahedron does not have
    if (origin * fourth > 0.0 && fourth * fourth > kFlatTetrahedron * kFlatTetrahedron * n.squaredNorm())
      continue;
    GapSimplex face{{a, b, c, Vec3::Zero()}, 3};
    const Vec3 p = nearest_of_triangle(face);
    if (const double square = p.squaredNorm(); square < least) least = square, found = p, best = face;
  }
  if (least < HUGE_VAL) s = best;
  return found;
}

Vec3 nearest_of(GapSimplex& s) {
  switch (s.count) {
    case 1:
      return s.p[0];
    case 2:
      return nearest_of_segment(s);
    case 3:
      return nearest_of_triangle(s);
    default:
      return nearest_of_tetrahedron(s);
  }
}

}  // namespace

double reach_along(const PointsView& b, const Vec3& n) {
  double least = 0.0;
  lowest_point(b, -n, least);
  return -least;
}

double separation(const PointsView& a, const PointsView& b, Vec3& axis, double low, double enough) {
  GapSimplex simplex;
  Vec3 n = axis;
  double best = -HUGE_VAL, distance = HUGE_VAL;
  for (int step = 0; step < kMostDirections; ++step) {
    double from_a = 0.0, from_b = 0.0;
    const Vec3 w = a[lowest_point(a, n, from_a)] - b[lowest_point(b, -n, from_b)];
    if (const double gap = from_a + from_b; gap > best) best = gap, axis = n;
    if (best >= enough || distance <= low) return best;
    if (step > 0 && distance - best <= (best > low ? kDistanceShare * distance : kGapExact)) return best;
    for (int i = 0; i < simplex.count; ++i)
      if (w == simplex.p[i]) return best;
    simplex.p[simplex.count++] = w;
    const Vec3 nearest = nearest_of(simplex);
    distance = nearest.norm();
    if (!std::isfinite(distance)) return best;  // of points on a line
    if (distance <= kNoDistance) return std::min(best, 0.0);
    n = nearest / distance;
  }
  return best;
}

}  // namespace omniflight::planning
