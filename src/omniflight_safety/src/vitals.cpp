#include "omniflight_safety/vitals.hpp"

#include <cmath>
#include <limits>

namespace omniflight::safety {
namespace {

/// True when value is over the limit, or no number.
bool over(double value, double limit) { return !(value <= limit); }

bool under(const std::optional<double>& value, double limit) {
  return limit > 0 && value && !(*value >= limit);
}

}  // namespace

double outside(const Fence& fence, const Vec3& p_W) {
  if (!p_W.allFinite()) return std::numeric_limits<double>::infinity();
  return std::max((fence.min - p_W).maxCoeff(), (p_W - fence.max).maxCoeff());
}

FaultSet judge(const Limits& limits, const Vitals& v) {
  FaultSet out;
  const auto put = [&out](Fault fault, bool present) { out.set(index(fault), present); };
  put(Fault::recorder_lost, !v.recorder);
  put(Fault::planner_lost, !v.planner);
  put(Fault::periods_missed, over(v.missed_share, limits.missed_share));
  put(Fault::operator_hold, v.wish == Wish::hold);
  put(Fault::operator_land, v.wish == Wish::land);
  put(Fault::operator_stop, v.wish == Wish::stop);
  put(Fault::emergency_stop, v.wish == Wish::cut);
  put(Fault::battery_low, under(v.battery_V, limits.battery_low_V));
  put(Fault::battery_empty, under(v.battery_V, limits.battery_empty_V));
  put(Fault::pose_lost, over(v.pose_age_s, limits.pose_stale_s));
  put(Fault::imu_lost, over(v.imu_age_s, limits.imu_stale_s));
  put(Fault::rotors_lost, over(v.hover_load, limits.hover_load));
  put(Fault::estimate_diverged, over(v.innovation_m, limits.innovation_m));
  put(Fault::commands_lost, limits.command_stale_s > 0 && over(v.command_age_s, limits.command_stale_s));
  put(Fault::board_lost, !v.boards);
  put(Fault::board_emergency, v.board_emergency);
  put(Fault::clock_broken, !v.clock);
  const double beyond_m = v.p_W ? outside(limits.fence, *v.p_W) : -1.0;
  put(Fault::geofence_left, over(beyond_m, 0.0));
  put(Fault::geofence_far, over(beyond_m, limits.fence.margin));
  return out;
}

}  // namespace omniflight::safety
