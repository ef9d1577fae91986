#include "actuation.hpp"

#include <cstdio>

namespace omniflight::planning {
namespace {

/// Of the largest inertial wrench on the way: what rounding leaves, as in WrenchSet::load.
constexpr double kUnreachable = 1e-6;
constexpr double kThrustRounding = 1e-10;  // of the weight

}  // namespace

Status check_actuation(const std::vector<TrajectoryKnot>& knots, const allocation::RotorLoad& rotors) {
  if (rotors.rank() == 6) return {};
  double largest = 0.0;
  Vec6 worst = Vec6::Zero();
  const TrajectoryKnot* at = nullptr;
  for (const TrajectoryKnot& knot : knots) {
    const auto wrench = rotors.inertial_wrench(knot.reference);
    largest = std::max(largest, wrench.size);
    if (wrench.unreachable_B.norm() > worst.norm()) worst = wrench.unreachable_B, at = &knot;
  }
  if (!at) return {};
  Reference still;
  still.q_WB = at->reference.q_WB;
  if (worst.norm() <= kUnreachable * largest + kThrustRounding * rotors.required_wrench(still).norm())
    return {};
  const bool force = worst.head<3>().norm() >= worst.tail<3>().norm();
  const Vec3 direction = (force ? worst.head<3>() : worst.tail<3>()).normalized();
  const Vec3 rpy = roll_pitch_yaw(at->reference.q_WB);
  char text[400];
  std::snprintf(
      text, sizeof text,
      "underactuated: the motion at roll %.1f, pitch %.1f, yaw %.1f deg needs a %s along (%.2f, %.2f, "
      "%.2f) of the body, and the rotors give none there at any speed (their allocation matrix has rank "
      "%d of 6)",
      to_degrees(rpy.x()), to_degrees(rpy.y()), to_degrees(rpy.z()), force ? "force" : "torque",
      direction.x(), direction.y(), direction.z(), rotors.rank());
  return bad_input(text, "", "Move along what the rotors give, or fly a vehicle that tilts its rotors");
}

}  // namespace omniflight::planning
