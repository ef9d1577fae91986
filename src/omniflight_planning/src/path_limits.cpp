#include "path_limits.hpp"

#include <cmath>

#include "text.hpp"

namespace omniflight::planning {
namespace {

/// What a place of the curve asks: affine in the point.
class Place {
 public:
  Place(const PoseCurve& curve, double u, const allocation::RotorLoad& rotors, double speed,
        const MotionLimits& limits)
      : rotors_(rotors), limits_(limits) {
    const Reference still = curve.at(u, 0, 0), moving = curve.at(u, 1, 0), starting = curve.at(u, 0, 1);
    hover_ = rotors.required_wrench(still);
    wrench_ << rotors.required_wrench(moving) - hover_, rotors.required_wrench(starting) - hover_;
    acceleration_ << moving.a_WB_W, starting.a_WB_W;
    turning_ << moving.dw_WB_B, starting.dw_WB_B;
    const double v = moving.v_WB_W.norm() / limits.speed, w = moving.w_WB_B.norm() / limits.rate;
    fastest_ = std::min(speed * speed, 1.0 / std::max({v * v, w * w, 1e-300}));
  }

  double fastest() const { return fastest_; }  // m^2/s^2, by the limits of speed and rate
  /// The largest share of a limit that the point needs: convex, and 1 where it is just kept.
  double use(const SpeedPoint& p) const {
    return std::max({rotors_.load(hover_ + wrench_ * p) / (1.0 - limits_.rotor_headroom),
                     (acceleration_ * p).norm() / limits_.acceleration,
                     (turning_ * p).norm() / limits_.angular_acceleration});
  }
  /// How far along an axis the limits let the point go: at least that, and no more than twice as far.
  double reach(const SpeedPoint& axis) const {
    constexpr double kNear = 1e-9, kFar = 1e12;
    double r = 1.0;
    while (r > kNear && use(r * axis) > 1.0) r *= 0.5;
    while (r < kFar && use(r * axis) <= 1.0) r *= 2.0;
    return r;
  }
  /// The points that keep the limits, by cutting planes (Kelley 1960): tangents at corners that do not.
  Polygon allowed(double x, double y) const {
    constexpr double kExact = 1e-4;
    constexpr int kMostCuts = 60;
    Polygon out(x, y);
    for (int cuts = 0; cuts < kMostCuts; ++cuts) {
      const auto beyond = std::find_if(out.corners().begin(), out.corners().end(),
                                       [&](const SpeedPoint& p) { return use(p) > 1.0 + kExact; });
      if (beyond == out.corners().end()) break;
      const SpeedPoint p = *beyond;
      const double value = use(p), dx = 1e-7 * std::max(p.x(), 1e-3 * x),
                   dy = 1e-7 * std::max(std::abs(p.y()), 1e-3 * y);
      const SpeedPoint slope((use(p + SpeedPoint(dx, 0)) - value) / dx,
                             (use(p + SpeedPoint(0, dy)) - value) / dy);
      out.clip(slope, 1.0 - value + slope.dot(p));
    }
    return out;
  }

 private:
  const allocation::RotorLoad& rotors_;
  const MotionLimits& limits_;
  Vec6 hover_;
  Eigen::Matrix<double, 6, 2> wrench_;
  Eigen::Matrix<double, 3, 2> acceleration_, turning_;
  double fastest_;
};

}  // namespace

Result<PathLimits> PathLimits::create(const PoseCurve& curve, const allocation::RotorLoad& rotors,
                                      const MotionLimits& limits, int steps, const Deadline& deadline) {
  const auto count = static_cast<std::size_t>(steps) + 1;
  return create(curve, std::vector(count, &rotors), std::vector(count, HUGE_VAL), limits, deadline);
}

Result<PathLimits> PathLimits::create(const PoseCurve& curve,
                                      const std::vector<const allocation::RotorLoad*>& rotors,
                                      const std::vector<double>& speeds, const MotionLimits& limits,
                                      const Deadline& deadline) {
  std::vector<Place> places;
  double most = 0.0;  // m/s^2
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    if (rotors[i]->rank() < 6)
      return fail(ErrorCode::incomplete, "the fastest ride is known of vehicles with rank 6 only");
    const double u = curve.length() * static_cast<double>(i) / static_cast<double>(rotors.size() - 1);
    places.emplace_back(curve, u, *rotors[i], speeds[i], limits);
    if (places.back().use(SpeedPoint::Zero()) > 1.0)
      return fail(ErrorCode::incomplete, "an attitude on the way cannot be hovered with the headroom");
    most = std::max(most, places.back().reach(SpeedPoint(0, 1)));
  }
  PathLimits out(curve.length());
  for (const Place& place : places) {
    constexpr double kBeyond = 16.0;  // where speed and acceleration offset each other
    if (deadline.passed()) return out_of_time(deadline, "finding the fastest ride");
    // no ride is faster than by the largest acceleration all the way
    const double x =
        std::min({place.fastest(), kBeyond * place.reach(SpeedPoint(1, 0)), 2.0 * curve.length() * most});
    const double y = kBeyond * std::max(place.reach(SpeedPoint(0, 1)), place.reach(SpeedPoint(0, -1)));
    out.allowed_.push_back(place.allowed(x, y));
  }
  return out;
}

Result<SpeedProfile> PathLimits::fastest(const std::vector<double>& shares) const {
  constexpr double kRounding = 1e-9;
  const auto n = static_cast<std::size_t>(steps());
  // x + 2 step y is the square of the speed at the next place
  const SpeedPoint next(1.0, 2.0 * length_ / static_cast<double>(n));
  const auto onward = [&](std::size_t i, double most) {
    Polygon out = allowed_[i].scaled(shares[i]);
    out.clip(next, most);
    out.clip(-next, kRounding * out.largest_x());  // the last place rests: a line of points
    return out;
  };
  // Backward: up to which speeds the rest of the way can be ridden. Rest is always one of them.
  std::vector<double> most(n + 1, 0.0);
  for (std::size_t i = n - 1; i > 0; --i) most[i] = onward(i, most[i + 1]).largest_x();
  // Forward: as fast as they allow.
  std::vector<double> squares(n + 1, 0.0);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    squares[i + 1] = onward(i, most[i + 1]).largest(next, squares[i]);
    if (!(squares[i + 1] > 0.0))
      return fail(ErrorCode::incomplete, text("no speed is possible at %.3f m of the curve",
                                              length_ * static_cast<double>(i) / static_cast<double>(n)));
  }
  return SpeedProfile(length_, squares);
}

}  // namespace omniflight::planning
