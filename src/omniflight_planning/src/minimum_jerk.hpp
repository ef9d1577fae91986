// Rides by the minimum-jerk law, at one tilt of the rotors or while it moves.
#pragma once

#include <functional>

#include "omniflight_planning/timing.hpp"

namespace omniflight::planning {

/// A ride from rest to rest in `duration` [s]; tilt: rad, over the curve's parameter.
std::vector<TrajectoryKnot> minimum_jerk_knots(const PoseCurve& curve,
                                               const std::function<double(double)>& tilt, int intervals,
                                               double duration);

/// The time [s], `slowest` at least, that the limits ask for of a ride of one second, each of whose knots has
/// its own rotors.
Result<double> least_time(const std::vector<TrajectoryKnot>& in_a_second,
                          const std::vector<const Rotors*>& rotors, const MotionLimits& limits,
                          double slowest, const Deadline& deadline);

}  // namespace omniflight::planning
