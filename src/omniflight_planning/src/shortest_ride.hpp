// The shortest time of a ride along a curve that keeps every limit.
#pragma once

#include <cmath>

#include "omniflight_planning/timing.hpp"

namespace omniflight::planning {

inline constexpr double kLongestRide = 600.0;  // s

/// Every limit but the rate of thrust, which is one of knots a period apart.
inline bool within_at_places(const MotionPeaks& p, const MotionLimits& limits) {
  return p.rotor_load <= 1.0 - limits.rotor_headroom && p.speed <= limits.speed &&
         p.acceleration <= limits.acceleration && p.rate <= limits.rate &&
         p.angular_acceleration <= limits.angular_acceleration;
}

inline bool within(const MotionPeaks& p, const MotionLimits& limits) {
  return within_at_places(p, limits) && p.thrust_rate.share <= 1.0 - limits.rotor_headroom;
}

/// The shortest duration [s] from `low` on at which fits(duration), bracketed and halved.
template <class Fits>
Result<double> shortest_time(double low, const Fits& fits, const Deadline& deadline) {
  const auto late = [&] { return out_of_time(deadline, "finding the shortest time of a ride"); };
  double high = low;
  while (high < kLongestRide && !fits(high)) {
    if (deadline.passed()) return late();
    low = high;
    high *= 1.5;
  }
  while (high - low > 0.5 * kKnotPeriod) {
    if (deadline.passed()) return late();
    (fits(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
  }
  return high;
}

/// Shortest knots(intervals, duration), bracketed and halved, that pass keeps(knots), a whole number of knot
/// periods long and `least` [s] at least.
template <class Knots, class Keeps>
Result<std::vector<TrajectoryKnot>> first_ride(double least, const Knots& knots, const Keeps& keeps,
                                               const Deadline& deadline) {
  const auto at = [&](int intervals) { return knots(intervals, intervals * kKnotPeriod); };
  const auto late = [&] { return out_of_time(deadline, "finding the shortest time of a ride"); };
  const int first = static_cast<int>(std::ceil(least / kKnotPeriod - 1e-9));
  int low = first - 1, high = first;
  // a few periods more as a rule; the lag of the motors, which shows here first, may ask for many
  for (int step = 1; high * kKnotPeriod < kLongestRide; step *= 2) {
    if (deadline.passed()) return late();
    if (auto found = at(high); keeps(found)) {
      for (; high - low > 1;) {
        if (deadline.passed()) return late();
        const int middle = low + (high - low) / 2;
        auto shorter = at(middle);
        const bool kept = keeps(shorter);
        (kept ? high : low) = middle;
        if (kept) found = std::move(shorter);
      }
      return found;
    }
    low = high, high += step;
  }
  return fail(ErrorCode::incomplete, "no ride of less than 600 s keeps the limits", "limits",
              "Allow more speed or acceleration, or shorten the way");
}

}  // namespace omniflight::planning
