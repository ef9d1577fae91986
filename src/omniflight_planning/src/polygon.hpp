// A convex polygon in the plane of a curve's speed and acceleration.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <vector>

namespace omniflight::planning {

/// Square of the speed x [m^2/s^2] and acceleration y [m/s^2] along a curve.
using SpeedPoint = Eigen::Vector2d;

/// Corners counter-clockwise; none is left where nothing is.
class Polygon {
 public:
  /// 0 <= x' <= x, -y <= y' <= y.
  Polygon(double x, double y) : corners_{{0, -y}, {x, -y}, {x, y}, {0, y}} {}
  const std::vector<SpeedPoint>& corners() const { return corners_; }

  /// What of it has normal . p <= offset.
  void clip(const SpeedPoint& normal, double offset) {
    std::vector<SpeedPoint> kept;
    kept.reserve(corners_.size() + 1);
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const SpeedPoint &a = corners_[i], &b = corners_[(i + 1) % corners_.size()];
      const double over_a = normal.dot(a) - offset, over_b = normal.dot(b) - offset;
      if (over_a <= 0.0) kept.push_back(a);
      if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0))
        kept.push_back(a + over_a / (over_a - over_b) * (b - a));
    }
    corners_ = std::move(kept);
  }
  Polygon scaled(double factor) const {
    Polygon out = *this;
    for (SpeedPoint& p : out.corners_) p *= factor;
    return out;
  }
  double largest_x() const {
    double out = 0.0;
    for (const SpeedPoint& p : corners_) out = std::max(out, p.x());
    return out;
  }
  /// The largest normal . p, 0 at least, of its points with this x, or with its largest x where none has it.
  double largest(const SpeedPoint& normal, double x) const {
    double out = 0.0;
    x = std::min(x, largest_x());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const SpeedPoint &a = corners_[i], &b = corners_[(i + 1) % corners_.size()];
      if (std::min(a.x(), b.x()) > x || std::max(a.x(), b.x()) < x) continue;
      if (a.x() == b.x())
        out = std::max({out, normal.dot(a), normal.dot(b)});
      else
        out = std::max(out, normal.dot(a + (x - a.x()) / (b.x() - a.x()) * (b - a)));
    }
    return out;
  }

 private:
  std::vector<SpeedPoint> corners_;
};

}  // namespace omniflight::planning
