// From a state in flight to rest.
#pragma once

#include "omniflight_planning/join.hpp"
#include "ride_leg.hpp"

namespace omniflight::planning {

/// The velocity as the quintic that has the state's velocity, acceleration and jerk at its start and none of
/// them at its end; the rotation vector from the state's attitude likewise, from rate and angular
/// acceleration. At rest the position is nobody's choice: v T / 2 + a T^2 / 10 + j T^3 / 120 further.
Knots stop_in(double duration, const FlightState& from);

/// The shortest stop, a whole number of knot periods, that keeps the limits of motion and rotors at every
/// knot and the clearance on the whole curve. One knot where the state is at rest. Errors: the state itself
/// exceeds a limit, or no stop keeps them (join_over_limits, join_blocked, with the value or the place), or
/// the deadline.
Result<Knots> come_to_rest(const FlightState& from, const AtTilt& here, const MotionLimits& limits,
                           const Deadline& deadline);

}  // namespace omniflight::planning
