#include "upright.hpp"

#include <algorithm>

#include "omniflight_files/files.hpp"
#include "text.hpp"

namespace omniflight::planning {
namespace {

/// Rounded as it is printed, without a minus before zero.
double tenths(double x) { return std::round(10.0 * x) / 10.0 + 0.0; }

}  // namespace

Result<Mission> with_headings(const Mission& mission, const vehicle::Vehicle& vehicle) {
  Mission out = mission;
  const bool asked = std::any_of(out.waypoints.begin(), out.waypoints.end(),
                                 [](const Waypoint& w) { return w.heading.has_value(); });
  if (!asked) return out;
  const auto flat = flat_vehicle(vehicle, std::clamp(0.0, vehicle.tilt.min, vehicle.tilt.max));
  if (!flat) return Failure(flat.error());
  for (Waypoint& w : out.waypoints)
    if (w.heading && *flat) w.pose.q_WB = (*flat)->upright(*w.heading);
  return out;
}

Status check_upright(const Waypoint& waypoint, const FlatVehicle& flat, const vehicle::Vehicle& vehicle,
                     bool is_start, const std::string& mission_file) {
  const Quat& q = waypoint.pose.q_WB;
  if (!is_finite(waypoint.pose) || flat.heading(q)) return {};
  const Vec3 asked = roll_pitch_yaw(q) * (180.0 / kPi), n = flat.thrust_axis_B;
  const Vec3 can = roll_pitch_yaw(flat.upright(flat.heading(q, kPi).value_or(0.0))) * (180.0 / kPi);
  const Vec3& p = waypoint.pose.p_WB;
  return bad_input(
      text("%s: %s: the attitude roll %.1f, pitch %.1f, yaw %.1f deg cannot be held: %s is underactuated, "
           "its rotors "
           "push along (%.2f, %.2f, %.2f) of the body only, and it rests with that axis upright. The "
           "position (%.2f, "
           "%.2f, %.2f) m is reachable with attitude: {rpy_deg: [%.1f, %.1f, %.1f]}",
           is_start ? "start_unhoverable" : "goal_unhoverable", waypoint.name.substr(0, 40).c_str(),
           asked.x(), asked.y(), asked.z(), files::shown(vehicle.name.substr(0, 40)).c_str(), n.x(), n.y(),
           n.z(), p.x(), p.y(), p.z(), tenths(can.x()), tenths(can.y()), tenths(can.z())),
      waypoint.where.empty() ? mission_file : waypoint.where,
      "Ask for position and heading; the attitude on the way follows from the acceleration");
}

Result<std::optional<Vec3>> axis_of_motion(const Mission& mission, double alpha, Tilts& tilts) {
  const auto first = tilts.at(alpha);
  if (!first) return Failure(first.error());
  std::optional<Vec3> axis;  // a mission that only holds is one of its first tilt
  if ((*first)->flat) axis = (*first)->flat->thrust_axis_B;
  std::string leaning, free;  // first waypoint that is reached either way
  for (std::size_t i = 1; i < mission.waypoints.size(); ++i) {
    const Waypoint &from = mission.waypoints[i - 1], &to = mission.waypoints[i];
    const auto here = tilts.at(alpha);
    if (!here) return Failure(here.error());
    const bool moves =
        (to.pose.p_WB - from.pose.p_WB).norm() > 1e-9 || to.pose.q_WB.angularDistance(from.pose.q_WB) > 1e-9;
    if (moves && (*here)->flat && leaning.empty()) leaning = to.name, axis = (*here)->flat->thrust_axis_B;
    if (moves && !(*here)->flat) {
      if (free.empty()) free = to.name;
      if (leaning.empty()) axis.reset();
    }
    alpha = to.alpha.value_or(alpha);
  }
  if (!leaning.empty() && !free.empty())
    return bad_input("mixed_actuation: at the tilt on the way to " + leaning +
                         " the vehicle leans into its motion, on the way to " + free +
                         " it commands its attitude; one control law flies a mission",
                     mission.file + ": alpha_deg", "Split the mission, or stay at tilts of one kind");
  return axis;
}

}  // namespace omniflight::planning
