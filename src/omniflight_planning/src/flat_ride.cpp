#include <cmath>

#include "actuation.hpp"
#include "omniflight_planning/flatness.hpp"
#include "shortest_ride.hpp"

namespace omniflight::planning {
namespace {

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
                                         const Rotors& rotors, const MotionLimits& limits,
                                         const Deadline& deadline) {
  const auto leans_little = [&](const std::vector<TrajectoryKnot>& knots) {
    return largest_lean(knots, vehicle) <= limits.lean;
  };
  const auto keeps_places = [&](const std::vector<TrajectoryKnot>& knots) {
    return within_at_places(peaks(knots, rotors), limits) && leans_little(knots);
  };
  const auto keeps = [&](const std::vector<TrajectoryKnot>& knots) {
    return within(peaks(knots, rotors), limits) && leans_little(knots);
  };
  const auto knots = [&](int intervals, double duration) {
    return sample(curve, vehicle, rotors.load().alpha(), intervals, duration);
  };
  // slower rides lean less, turn slower and need less of the rotors, down to hovering
  const auto least = shortest_time(
      0.1, [&](double T) { return keeps_places(knots(kShapeSamples, T)); }, deadline);
  if (!least) return Failure(least.error());
  auto found = first_ride(*least, knots, keeps, deadline);
  if (!found) return found;
  if (auto ok = check_actuation(*found, rotors.load()); !ok) return Failure(ok.error());
  return found;
}

}  // namespace omniflight::planning
