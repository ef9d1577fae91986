#include "solid.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

using Kind = vehicle::CollisionShape::Kind;

constexpr double kExact = 1e-4;          // m
constexpr double kBoundRounding = 1e-9;  // m, taken off every bound
constexpr int kMostProjections = 64;

}  // namespace

double Solid::reach(const Vec3& unit) const {
  switch (kind_) {
    case Kind::sphere:
      return size_.x();
    case Kind::cylinder: {
      const double along = std::abs(R_WS_.col(2).dot(unit));
      return size_.x() * std::sqrt(std::max(0.0, 1.0 - along * along)) + 0.5 * size_.y() * along;
    }
    case Kind::box:
      return 0.5 * (R_WS_.transpose() * unit).cwiseAbs().dot(size_);
  }
  return 0.0;
}

Vec3 Solid::nearest(const Vec3& x) const {
  const Vec3 d = x - center_;
  switch (kind_) {
    case Kind::sphere: {
      const double length = d.norm();
      return length <= size_.x() ? x : Vec3(center_ + d * (size_.x() / length));
    }
    case Kind::cylinder: {
      const Vec3 axis = R_WS_.col(2);
      const double along = axis.dot(d);
      const Vec3 across = d - along * axis;
      const double length = across.norm(), half = 0.5 * size_.y();
      return center_ + axis * std::clamp(along, -half, half) +
             across * (length <= size_.x() ? 1.0 : size_.x() / length);
    }
    case Kind::box:
      return center_ + R_WS_ * (R_WS_.transpose() * d).cwiseMax(-0.5 * size_).cwiseMin(0.5 * size_);
  }
  return center_;
}

double Solid::gap_along(const Vec3& unit, const Vec3& cube, double half) const {
  return std::abs(unit.dot(cube - center_)) - half * unit.cwiseAbs().sum() - reach(unit);
}

double Solid::distance_to_cube(const Vec3& cube, double half, double enough) const {
  const auto in_cube = [&](const Vec3& y) { return Vec3(cube + (y - cube).cwiseMax(-half).cwiseMin(half)); };
  if (kind_ == Kind::sphere)
    return std::max(0.0, (in_cube(center_) - center_).norm() - size_.x() - kBoundRounding);
  // Faces first: between nearly parallel ones the projections below converge slowly.
  double low = 0.0;
  for (int k = kind_ == Kind::box ? 0 : 2; k < 3; ++k)
    low = std::max(low, gap_along(R_WS_.col(k), cube, half));
  for (int k = 0; k < 3 && low < enough; ++k) low = std::max(low, gap_along(Vec3::Unit(k), cube, half));
  // Alternating projections (von Neumann; Cheney and Goldstein 1959): the upper bound is the distance of the
  // points, the lower one the gap along the line between them.
  Vec3 x = in_cube(center_);
  for (int i = 0; i < kMostProjections && low < enough; ++i) {
    const Vec3 y = nearest(x);
    const Vec3 v = x - y;
    const double high = v.norm();
    if (high <= kExact) return 0.0;
    low = std::max(low, gap_along(v / high, cube, half));
    if (high - low <= kExact) break;
    x = in_cube(y);
  }
  return std::max(0.0, low - kBoundRounding);
}

}  // namespace omniflight::planning
