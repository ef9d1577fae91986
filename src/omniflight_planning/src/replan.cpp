#include "omniflight_planning/replan.hpp"

namespace omniflight::planning {
namespace {

constexpr double kSameTime = 1e-6;  // s

}  // namespace

Result<FlightState> state_or_rest(const Trajectory& flown, double t) {
  if (flown.empty() || !(t >= 0.0)) return bad_input("there is no trajectory at this time to begin from");
  if (t < flown.duration()) return state_at(flown, t);
  const Reference& last = flown.knots().back().reference;
  FlightState out;
  out.reference.p_WB = last.p_WB;
  out.reference.q_WB = last.q_WB;
  out.reference.alpha = last.alpha;
  return out;
}

Result<Trajectory> joined(const Trajectory& flown, double join, const Trajectory& next) {
  std::vector<TrajectoryKnot> knots;
  for (const TrajectoryKnot& knot : flown.knots())
    if (knot.t < join - kSameTime) knots.push_back(knot);
  for (TrajectoryKnot knot : next.knots()) {
    knot.t += join;
    knots.push_back(knot);
  }
  return Trajectory::create(std::move(knots));
}

Result<Replan> replan(const Mission& mission, const Trajectory& flown, double join, PlanOptions options) {
  const auto state = state_or_rest(flown, join);
  if (!state) return Failure(state.error());
  options.from = *state;
  auto plan = plan_mission(mission, options);
  if (!plan) return Failure(plan.error());
  auto whole = joined(flown, join, plan->trajectory);
  if (!whole) return Failure(whole.error());
  return Replan{std::move(*plan), join, std::move(*whole)};
}

}  // namespace omniflight::planning
