#include "triangle.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {

bool touches_box(const Triangle& t, const Vec3& center, const Vec3& half) {
  const Vec3 v0 = t[0] - center, v1 = t[1] - center, v2 = t[2] - center;
  const double slack =
      1e-9 * (1.0 + center.cwiseAbs().maxCoeff() +
              std::max({v0.cwiseAbs().maxCoeff(), v1.cwiseAbs().maxCoeff(), v2.cwiseAbs().maxCoeff()}));
  const Vec3 h = half + Vec3::Constant(slack);
  const auto apart = [&](const Vec3& axis) {
    const double p0 = axis.dot(v0), p1 = axis.dot(v1), p2 = axis.dot(v2), r = axis.cwiseAbs().dot(h);
    return std::min({p0, p1, p2}) > r || std::max({p0, p1, p2}) < -r;
  };
  for (int k = 0; k < 3; ++k)
    if (apart(Vec3::Unit(k))) return false;
  const Vec3 edges[3] = {v1 - v0, v2 - v1, v0 - v2};
  if (apart(edges[0].cross(edges[1]))) return false;
  for (const Vec3& e : edges)
    for (int k = 0; k < 3; ++k)
      if (apart(Vec3::Unit(k).cross(e))) return false;
  return true;
}

double segments_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  constexpr double kPoint = 1e-24;  // m^2: a segment of no length
  const Vec3 u = a1 - a0, v = b1 - b0, w = a0 - b0;
  const double a = u.squaredNorm(), e = v.squaredNorm(), f = v.dot(w);
  double s = 0.0, t = 0.0;
  if (a <= kPoint && e <= kPoint) return w.norm();
  if (a <= kPoint) {
    t = std::clamp(f / e, 0.0, 1.0);
  } else {
    const double c = u.dot(w);
    if (e <= kPoint) {
      s = std::clamp(-c / a, 0.0, 1.0);
    } else {
      const double b = u.dot(v), d = a * e - b * b;
      if (d > 1e-14 * a * e) s = std::clamp((b * f - c * e) / d, 0.0, 1.0);
      t = (b * s + f) / e;
      if (t < 0.0) {
        t = 0.0;
        s = std::clamp(-c / a, 0.0, 1.0);
      } else if (t > 1.0) {
        t = 1.0;
        s = std::clamp((b - c) / a, 0.0, 1.0);
      }
    }
  }
  return (w + s * u - t * v).norm();
}

double point_triangle_distance(const Vec3& p, const Triangle& t) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double area = n.squaredNorm();
  bool inside = area > 0.0;
  double edge = HUGE_VAL;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &from = t[static_cast<std::size_t>(k)], &to = t[static_cast<std::size_t>((k + 1) % 3)];
    const Vec3 along = to - from, away = p - from;
    inside = inside && along.cross(away).dot(n) >= 0.0;
    const double square = along.squaredNorm();
    const double foot = square > 0.0 ? std::clamp(away.dot(along) / square, 0.0, 1.0) : 0.0;
    edge = std::min(edge, (away - foot * along).squaredNorm());
  }
  return inside ? std::abs((p - t[0]).dot(n)) / std::sqrt(area) : std::sqrt(edge);
}

namespace {

/// Whether the segment passes through the triangle's inside; its edges are left to the distances.
bool pierces(const Vec3& from, const Vec3& to, const Triangle& t) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double d0 = n.dot(from - t[0]), d1 = n.dot(to - t[0]);
  if ((d0 > 0.0) == (d1 > 0.0) || d0 == d1) return false;
  const Vec3 at = from + (d0 / (d0 - d1)) * (to - from);
  for (std::size_t k = 0; k < 3; ++k)
    if ((t[(k + 1) % 3] - t[k]).cross(at - t[k]).dot(n) < 0.0) return false;
  return true;
}

}  // namespace

double triangles_distance(const Triangle& a, const Triangle& b) {
  double best = HUGE_VAL;
  for (std::size_t i = 0; i < 3; ++i)
    if (pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a)) return 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      best = std::min(best, segments_distance(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
    best = std::min({best, point_triangle_distance(a[i], b), point_triangle_distance(b[i], a)});
  }
  return best;
}

}  // namespace omniflight::planning
