#include <cmath>

#include "actuation.hpp"
#include "omniflight_planning/flatness.hpp"

namespace omniflight::planning {
namespace {

constexpr int kShapeSamples = 400;
constexpr double kLongest = 600.0;  // s, for one ride

/// s^5 (126 - 420 s + 540 s^2 - 315 s^3 + 70 s^4) on [0, 1] with four derivatives, which vanish at both ends.
std::array<double, 5> law(double s) {
  const double w = s * (1.0 - s), d = 1.0 - 2.0 * s;
  return {std::pow(s, 5) * (126.0 + s * (-420.0 + s * (540.0 + s * (-315.0 + 70.0 * s)))),
          630.0 * w * w * w * w, 2520.0 * w * w * w * d, 2520.0 * w * w * (3.0 * d * d - 2.0 * w),
          15120.0 * w * d * (d * d - 3.0 * w)};
}

/// Derivatives by time of x(u(t)), from those of x by u and of u by time (Faa di Bruno).
FlatMotion chained(const FlatMotion& x, const std::array<double, 5>& u) {
  const double u1 = u[1], u2 = u[2], u3 = u[3], u4 = u[4];
  return {x[0], x[1] * u1, x[2] * (u1 * u1) + x[1] * u2,
          x[3] * (u1 * u1 * u1) + x[2] * (3.0 * u1 * u2) + x[1] * u3,
          x[4] * (u1 * u1 * u1 * u1) + x[3] * (6.0 * u1 * u1 * u2) + x[2] * (3.0 * u2 * u2 + 4.0 * u1 * u3) +
              x[1] * u4};
}

std::vector<TrajectoryKnot> sample(const FlatCurve& curve, const FlatVehicle& vehicle, double alpha,
                                   int intervals, double duration) {
  std::vector<TrajectoryKnot> knots;
  knots.reserve(static_cast<std::size_t>(intervals) + 1);
  for (int i = 0; i <= intervals; ++i) {
    std::array<double, 5> u = law(static_cast<double>(i) / intervals);
    double scale = curve.length();
    for (double& value : u) value *= scale, scale /= duration;
    Reference r = flat_reference(chained(curve.at(u[0]), u), vehicle);
    r.alpha = alpha;
    knots.push_back({duration * i / intervals, r});
  }
  return knots;
}

}  // namespace

Result<std::vector<TrajectoryKnot>> ride(const FlatCurve& curve, const FlatVehicle& vehicle,
                                         const allocation::RotorLoad& rotors, const MotionLimits& limits,
                                         const Deadline& deadline) {
  const auto keeps = [&](const std::vector<TrajectoryKnot>& knots) {
    const MotionPeaks p = peaks(knots, rotors);
    return p.rotor_load <= 1.0 - limits.rotor_headroom && p.speed <= limits.speed &&
           p.acceleration <= limits.acceleration && p.rate <= limits.rate &&
           p.angular_acceleration <= limits.angular_acceleration &&
           largest_lean(knots, vehicle) <= limits.lean;
  };
  const auto fits = [&](double T) { return keeps(sample(curve, vehicle, rotors.alpha(), kShapeSamples, T)); };
  const auto late = [&] { return out_of_time(deadline, "finding the shortest time of a ride"); };
  // slower rides lean less, turn slower and need less of the rotors, down to hovering
  double low = 0.1, high = low;
  while (high < kLongest && !fits(high)) {
    if (deadline.passed()) return late();
    low = high;
    high *= 1.5;
  }
  while (high - low > 0.5 * kKnotPeriod) {
    if (deadline.passed()) return late();
    (fits(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
  }
  for (int intervals = static_cast<int>(std::ceil(high / kKnotPeriod - 1e-9));
       intervals * kKnotPeriod < kLongest; ++intervals) {
    if (deadline.passed()) return late();
    auto knots = sample(curve, vehicle, rotors.alpha(), intervals, intervals * kKnotPeriod);
    if (!keeps(knots)) continue;
    if (auto ok = check_actuation(knots, rotors); !ok) return Failure(ok.error());
    return knots;
  }
  return fail(ErrorCode::incomplete, "no ride of less than 600 s keeps the limits", "limits",
              "Allow more speed or acceleration, or shorten the way");
}

}  // namespace omniflight::planning
