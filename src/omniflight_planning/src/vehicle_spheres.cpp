#include "omniflight_planning/vehicle_spheres.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

using Kind = vehicle::CollisionShape::Kind;

vehicle::CollisionShape cylinder(const Vec3& center, const Vec3& axis, double radius, double length) {
  return {Kind::cylinder, center, shortest_rotation(Vec3::UnitZ(), axis), Vec3(radius, length, 0.0)};
}

/// 19 circles of 0.2845 R cover a circle of radius R: one in the middle, 6 at 0.49 R, 12 at 0.86 R.
SphereGroup cover_disc(const Vec3& center, const Vec3& normal, double radius) {
  SphereGroup group{{center, radius}, {}, cylinder(center, normal, radius, 0.0)};
  const Vec3 x = normal.unitOrthogonal(), y = normal.cross(x);
  const double r = 0.2845 * radius;
  group.spheres.push_back({center, r});
  for (int k = 0; k < 6; ++k) {
    const double a = k * kPi / 3.0;
    group.spheres.push_back({center + 0.49 * radius * (std::cos(a) * x + std::sin(a) * y), r});
  }
  for (int k = 0; k < 12; ++k) {
    const double a = k * kPi / 6.0;
    group.spheres.push_back({center + 0.86 * radius * (std::cos(a) * x + std::sin(a) * y), r});
  }
  return group;
}

/// Upright cylinder about `axis` through `center`: slices that are about as long as they are wide.
SphereGroup cover_rod(const Vec3& center, const Vec3& axis, double radius, double length) {
  SphereGroup group{{center, std::hypot(radius, 0.5 * length)}, {}, cylinder(center, axis, radius, length)};
  const int n = std::clamp(static_cast<int>(std::ceil(length / std::max(1e-6, 1.5 * radius))), 1, 200);
  const double slice = length / n, r = std::hypot(radius, 0.5 * slice);
  for (int k = 0; k < n; ++k)
    group.spheres.push_back({center + axis * (slice * (k + 0.5) - 0.5 * length), r});
  return group;
}

SphereGroup cover_box(const Vec3& center, const Quat& q_BS, const Vec3& edges) {
  SphereGroup group{{center, 0.5 * edges.norm()}, {}, {Kind::box, center, q_BS, edges}};
  const double target = std::max(0.5 * edges.minCoeff(), edges.maxCoeff() / 20.0);
  Eigen::Vector3i n;
  for (int k = 0; k < 3; ++k) n[k] = std::clamp(static_cast<int>(std::ceil(edges[k] / target - 1e-9)), 1, 20);
  const Vec3 cell = edges.cwiseQuotient(n.cast<double>());
  for (int x = 0; x < n.x(); ++x)
    for (int y = 0; y < n.y(); ++y)
      for (int z = 0; z < n.z(); ++z) {
        const Vec3 p = cell.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5)) - 0.5 * edges;
        group.spheres.push_back({center + q_BS * p, 0.5 * cell.norm()});
      }
  return group;
}

/// Radius of the largest ball about the body origin inside a convex shape; 0 when the origin is outside.
double inscribed(const vehicle::CollisionShape& s) {
  const Vec3 o = s.q_BS.conjugate() * -s.p_BS;  // body origin in the shape's frame
  double r = 0.0;
  switch (s.kind) {
    case Kind::sphere:
      r = s.size.x() - o.norm();
      break;
    case Kind::cylinder:
      r = std::min(s.size.x() - o.head<2>().norm(), 0.5 * s.size.y() - std::abs(o.z()));
      break;
    case Kind::box:
      r = (0.5 * s.size - o.cwiseAbs()).minCoeff();
      break;
  }
  return std::max(0.0, r);
}

}  // namespace

VehicleSpheres cover_with_spheres(const vehicle::Vehicle& vehicle, double alpha) {
  VehicleSpheres out;
  for (int i = 0; i < vehicle.rotor_count(); ++i) {
    const auto& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    out.groups.push_back(cover_disc(rotor.p_BR, vehicle.rotor_axis(i, alpha), rotor.radius));
    if (vehicle.collision.empty() && rotor.p_BR.norm() > 0.0)
      out.groups.push_back(
          cover_rod(0.5 * rotor.p_BR, rotor.p_BR.normalized(), kAssumedArmRadius, rotor.p_BR.norm()));
  }
  for (const auto& shape : vehicle.collision) {
    switch (shape.kind) {
      case Kind::sphere:
        out.groups.push_back({{shape.p_BS, shape.size.x()}, {{shape.p_BS, shape.size.x()}}, shape});
        break;
      case Kind::cylinder:
        out.groups.push_back(
            cover_rod(shape.p_BS, shape.q_BS * Vec3::UnitZ(), shape.size.x(), shape.size.y()));
        break;
      case Kind::box:
        out.groups.push_back(cover_box(shape.p_BS, shape.q_BS, shape.size));
        break;
    }
    out.inscribed_radius = std::max(out.inscribed_radius, inscribed(shape));
  }
  for (const auto& group : out.groups) {
    double farthest = 0.0;
    for (const auto& s : group.spheres) farthest = std::max(farthest, s.p_BS.norm() + s.radius);
    const double as_one = group.bound.p_BS.norm() + group.bound.radius;
    out.bounding_radius = std::max(out.bounding_radius, std::min(farthest, as_one));
  }
  return out;
}

}  // namespace omniflight::planning
