// States in flight that a plan may begin from.
#pragma once

#include "omniflight_core/result.hpp"
#include "omniflight_core/trajectory.hpp"

namespace omniflight::planning {

/// What is flown at one instant: position to its third derivative, attitude to its second.
struct FlightState {
  Reference reference;
  Vec3 j_WB_W = Vec3::Zero();  ///< m/s^3, jerk of the body origin
};

/// The state of a trajectory at t [s]; the jerk is that just before t, of what has been flown. Refused: times
/// outside of it, and trajectories of one knot.
Result<FlightState> state_at(const Trajectory& trajectory, double t);

/// Jerk [m/s^3] of the position at `s` [s] after a knot: third derivative of the quintic to the next.
Vec3 jerk_between(const TrajectoryKnot& k0, const TrajectoryKnot& k1, double s);

/// Neither motion nor acceleration, to a millionth of a unit.
bool at_rest(const FlightState& state);

}  // namespace omniflight::planning
