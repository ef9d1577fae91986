#include "ride_tilting.hpp"

#include <algorithm>
#include <optional>

#include "leg_shapes.hpp"
#include "minimum_jerk.hpp"
#include "ride_shortest.hpp"
#include "shortest_ride.hpp"
#include "tilt.hpp"
#include "tilting_check.hpp"

namespace omniflight::planning {
namespace {

/// A curve and the way of the tilt along it.
struct TiltingRide {
  PoseCurve curve;
  TiltWay way;
  double least = 0.0;  // s

  Knots knots(int intervals, double duration) const {
    return minimum_jerk_knots(
        curve, [this](double u) { return way.at(u); }, intervals, duration);
  }
};

/// The time that limits, rotors and servo ask for.
Result<double> least_time_of(const TiltingRide& c, const vehicle::Vehicle& vehicle,
                             const MotionLimits& limits, const Deadline& deadline) {
  const Knots knots = c.knots(kShapeSamples, 1.0);
  std::vector<Rotors> rotors;
  rotors.reserve(knots.size());
  std::vector<const Rotors*> each;
  for (const TrajectoryKnot& knot : knots) {
    if (deadline.passed()) return out_of_time(deadline, "timing a ride on which the tilt moves");
    auto made = Rotors::create(vehicle, knot.reference.alpha, limits.rotor_headroom);
    if (!made) return Failure(made.error());
    rotors.push_back(std::move(*made));
    each.push_back(&rotors.back());
  }
  return least_time(knots, each, limits, fastest_tilt(knots) / (kShareOfRate * vehicle.tilt.rate), deadline);
}

Result<Knots> ride(const TiltingRide& c, const vehicle::Vehicle& vehicle, const MotionLimits& limits,
                   const Deadline& deadline) {
  std::optional<Error> problem;
  auto knots = first_ride(
      c.least, [&](int intervals, double duration) { return c.knots(intervals, duration); },
      [&](const Knots& some) {
        if (fastest_tilt(some) > kShareOfRate * vehicle.tilt.rate) return false;
        const auto most =
            peaks_while_tilting(vehicle, some, {0, some.size() - 1, true}, limits.rotor_headroom, deadline);
        if (!most) problem = most.error();
        return most && within(*most, limits);
      },
      deadline);
  if (!knots && problem) return Failure(*problem);
  return knots;
}

Result<bool> is_free(const Knots& knots, const vehicle::Vehicle& vehicle, Tilts& tilts,
                     const Deadline& deadline) {
  const auto trajectory = Trajectory::create(knots);
  if (!trajectory) return Failure(trajectory.error());
  const auto found = curve_while_tilting(*trajectory, {0, knots.size() - 1, true}, vehicle, tilts, deadline);
  if (!found) return Failure(found.error());
  return found->free;
}

}  // namespace

Result<Ridden> ride_tilting(const std::vector<Path>& paths, double from, double to,
                            const vehicle::Vehicle& vehicle, Tilts& tilts, const MotionLimits& limits,
                            Timing timing, const Deadline& deadline) {
  constexpr double kShareOfTime = 0.3;  // of what is left, for a shorter timing
  const auto range = tilts.range(from, to);
  if (!range) return Failure(range.error());
  std::vector<TiltingRide> candidates;
  std::optional<Error> problem;
  for (const Path& shape : shapes_of(paths)) {
    const PoseCurve curve(shape);
    for (TiltWay& way : tilt_ways(curve, *range, limits.rotor_headroom)) {
      TiltingRide c{curve, std::move(way)};
      const auto least = least_time_of(c, vehicle, limits, deadline);
      if (!least) {
        problem = least.error();
        continue;
      }
      c.least = *least;
      candidates.push_back(std::move(c));
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const TiltingRide& a, const TiltingRide& b) { return a.least < b.least; });
  for (const TiltingRide& c : candidates) {
    if (deadline.passed()) break;
    auto knots = ride(c, vehicle, limits, deadline);
    if (!knots) {
      problem = knots.error();
      continue;
    }
    const auto free = is_free(*knots, vehicle, tilts, deadline);
    if (!free) return Failure(free.error());
    if (!*free) continue;
    if (timing == Timing::shortest) {
      auto faster = ride_shortest_tilting(c.curve, c.way, vehicle, limits, *knots,
                                          deadline.within(kShareOfTime * deadline.left()));
      const auto clear = is_free(faster, vehicle, tilts, deadline);
      if (clear && *clear) knots = std::move(faster);
    }
    return Ridden{std::move(*knots), false};
  }
  if (deadline.passed()) return out_of_time(deadline, "timing a ride");
  if (candidates.empty() && problem) return Failure(*problem);
  return fail(ErrorCode::incomplete, kBlocked);
}

}  // namespace omniflight::planning
