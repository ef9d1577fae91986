#include <cmath>
#include <unsupported/Eigen/Splines>

#include "omniflight_planning/flatness.hpp"
#include "rotation_length.hpp"

namespace omniflight::planning {
namespace {

constexpr int kDegree = 5;  // four continuous derivatives
using Spline = Eigen::Spline<double, 4, kDegree>;
using Point = Eigen::Vector4d;

}  // namespace

struct FlatCurve::Impl {
  double length = 0.0;
  Point first = Point::Zero(), slope = Point::Zero();  // of a straight line, where there is no spline
  std::optional<Spline> spline;
};

FlatCurve::~FlatCurve() = default;
FlatCurve::FlatCurve(FlatCurve&&) noexcept = default;
FlatCurve& FlatCurve::operator=(FlatCurve&&) noexcept = default;

FlatCurve::FlatCurve(const std::vector<Pose>& poses, const FlatVehicle& vehicle)
    : impl_(std::make_unique<Impl>()) {
  std::vector<Point> points;
  std::vector<double> u;
  for (const Pose& pose : poses) {
    Point x;
    x << pose.p_WB + pose.q_WB * vehicle.p_BBcm, vehicle.heading(pose.q_WB, kPi).value_or(0.0);
    if (!points.empty()) {
      x[3] = points.back()[3] + std::remainder(x[3] - points.back()[3], 2.0 * kPi);
      const Point d = x - points.back();
      const double step = d.head<3>().norm() + kRotationLength * std::abs(d[3]);
      if (step < 1e-9) continue;
      u.push_back(u.back() + step);
    } else {
      u.push_back(0.0);
    }
    points.push_back(x);
  }
  Impl& c = *impl_;
  c.length = u.back();
  c.first = points.front();
  if (points.size() < 2) return;
  if (points.size() == 2) {
    c.slope = (points[1] - points[0]) / c.length;
    return;
  }
  // a spline of degree 5 takes six points: motions are cut in halves until there are as many
  while (points.size() <= kDegree) {
    std::vector<Point> finer{points.front()};
    std::vector<double> finer_u{u.front()};
    for (std::size_t i = 1; i < points.size(); ++i) {
      finer.push_back(0.5 * (points[i - 1] + points[i])), finer_u.push_back(0.5 * (u[i - 1] + u[i]));
      finer.push_back(points[i]), finer_u.push_back(u[i]);
    }
    points = std::move(finer), u = std::move(finer_u);
  }
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix<double, 4, Eigen::Dynamic> values(4, n);
  Spline::KnotVectorType places(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    values.col(i) = points[static_cast<std::size_t>(i)];
    places[i] = u[static_cast<std::size_t>(i)] / c.length;
  }
  c.spline = Eigen::SplineFitting<Spline>::Interpolate(values, kDegree, places);
}

double FlatCurve::length() const { return impl_->length; }

FlatMotion FlatCurve::at(double u) const {
  const Impl& c = *impl_;
  FlatMotion out;
  out.fill(Point::Zero());
  if (!c.spline) {
    out[0] = c.first + c.slope * u;
    out[1] = c.slope;
    return out;
  }
  const auto d = c.spline->derivatives<4>(std::clamp(u / c.length, 0.0, 1.0), 4);
  double scale = 1.0;
  for (int k = 0; k <= 4; ++k, scale /= c.length)
    out[static_cast<std::size_t>(k)] = d.col(k).matrix() * scale;
  return out;
}

}  // namespace omniflight::planning
