// A plan that takes the place of another one while that is flown.
#pragma once

#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {

struct Replan {
  Plan plan;              ///< from the state at `join` on; its time begins there
  double join = 0.0;      ///< s, in the time of the trajectory that was flown
  Trajectory trajectory;  ///< what was flown up to `join`, the plan from then on: one motion in one time
};

/// The state of a trajectory at t [s], which may lie after its end, where it rests.
Result<FlightState> state_or_rest(const Trajectory& flown, double t);

/// `flown` before `join` [s], from then on `next`, whose own time begins there.
Result<Trajectory> joined(const Trajectory& flown, double join, const Trajectory& next);

/// Plans a mission (another goal, or another map) from the state that `flown` has at `join` [s]. The vehicle
/// comes to rest and goes on to the mission's waypoints, as PlanOptions::from says. Where there is no such
/// plan, the error says why, and `flown` is what is flown.
Result<Replan> replan(const Mission& mission, const Trajectory& flown, double join, PlanOptions options = {});

}  // namespace omniflight::planning
