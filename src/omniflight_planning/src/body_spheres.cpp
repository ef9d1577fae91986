// Spheres that cover the triangles of a rigid body.
#include <algorithm>
#include <cmath>

#include "omniflight_planning/vehicle_spheres.hpp"

namespace omniflight::planning {
namespace {

using Corners = std::array<Vec3, 3>;

constexpr std::size_t kMostGroups = 64;  // as many as a check keeps apart

struct Piece {
  Corners corners;
  BodySphere sphere;
};

/// The smallest sphere about a point of the triangle that holds it: its circumscribed circle, or the one over
/// its longest edge where the angle against it is not acute.
BodySphere smallest_sphere(const Corners& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
    if ((a - c).dot(b - c) <= 0.0) return {0.5 * (a + b), 0.5 * (a - b).norm() * (1.0 + 1e-12)};
  }
  const Vec3 u = t[1] - t[0], v = t[2] - t[0], n = u.cross(v);
  const Vec3 way = (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2.0 * n.squaredNorm());
  const Vec3 center = t[0] + way;
  return {center,
          std::max({(center - t[0]).norm(), (center - t[1]).norm(), (center - t[2]).norm()}) * (1.0 + 1e-12)};
}

/// The two halves across the longest edge.
std::array<Corners, 2> halves(const Corners& t) {
  std::size_t longest = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if ((t[(k + 1) % 3] - t[k]).squaredNorm() > (t[(longest + 1) % 3] - t[longest]).squaredNorm())
      longest = k;
  const Vec3 &a = t[longest], &b = t[(longest + 1) % 3], &c = t[(longest + 2) % 3];
  const Vec3 middle = 0.5 * (a + b);
  return {Corners{a, middle, c}, Corners{middle, b, c}};
}

/// Pieces no larger than `radius` [m], the largest ones halved first, up to kMostBodySpheres.
std::vector<Piece> pieces_of(const TriangleMesh& body, double radius) {
  const auto smaller = [](const Piece& a, const Piece& b) { return a.sphere.radius < b.sphere.radius; };
  std::vector<Piece> out;
  for (std::size_t i = 0; i < body.triangles.size(); ++i)
    out.push_back({body.corners(i), smallest_sphere(body.corners(i))});
  std::make_heap(out.begin(), out.end(), smaller);
  while (out.size() < kMostBodySpheres && out.front().sphere.radius > radius) {
    std::pop_heap(out.begin(), out.end(), smaller);
    const auto parts = halves(out.back().corners);
    out.pop_back();
    for (const Corners& part : parts) {
      out.push_back({part, smallest_sphere(part)});
      std::push_heap(out.begin(), out.end(), smaller);
    }
  }
  return out;
}

void group(std::vector<Piece>& pieces, std::size_t first, std::size_t count, std::size_t most,
           std::vector<SphereGroup>& out) {
  const auto begin = pieces.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = begin + static_cast<std::ptrdiff_t>(count);
  Vec3 low = begin->sphere.p_BS, high = low;
  for (auto p = begin; p != end; ++p)
    low = low.cwiseMin(p->sphere.p_BS), high = high.cwiseMax(p->sphere.p_BS);
  if (count > most) {
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t half = count / 2;
    std::nth_element(
        begin, begin + static_cast<std::ptrdiff_t>(half), end,
        [axis](const Piece& a, const Piece& b) { return a.sphere.p_BS[axis] < b.sphere.p_BS[axis]; });
    group(pieces, first, half, most, out);
    group(pieces, first + half, count - half, most, out);
    return;
  }
  SphereGroup made;
  made.bound.p_BS = 0.5 * (low + high);
  for (auto p = begin; p != end; ++p) {
    made.spheres.push_back(p->sphere);
    made.triangles.push_back(p->corners);
    for (const Vec3& corner : p->corners)
      made.bound.radius = std::max(made.bound.radius, (corner - made.bound.p_BS).norm() * (1.0 + 1e-12));
  }
  out.push_back(std::move(made));
}

}  // namespace

VehicleSpheres cover_with_spheres(const TriangleMesh& body, double share) {
  VehicleSpheres out;
  for (const auto& triangle : body.triangles)
    for (const auto i : triangle)
      out.bounding_radius = std::max(out.bounding_radius, body.vertices[i].norm());
  auto pieces = pieces_of(body, share * out.bounding_radius);
  if (pieces.empty()) return out;
  // halving until `most` fit leaves at most twice the number that would be needed
  const std::size_t most = std::max<std::size_t>(12, 2 * pieces.size() / kMostGroups + 1);
  group(pieces, 0, pieces.size(), most, out.groups);
  return out;
}

}  // namespace omniflight::planning
