// The attitude that a desired acceleration asks of a vehicle with one direction of force.
#pragma once

#include <array>

#include "omniflight_control/law.hpp"

namespace omniflight::control {

struct AttitudeTarget {
  Quat q_WD = Quat::Identity();
  Vec3 w_WD_D = Vec3::Zero();          ///< rad/s, in its own axes
  Vec3 dw_WD_D = Vec3::Zero();         ///< rad/s^2, in its own axes
  Vec3 acceleration_W = Vec3::Zero();  ///< m/s^2, what is left of the demand within the lean limit
  bool limited = false;                ///< the lean limit or the least lift cut the demand
};

/// The reference's attitude, swung by the shortest way so that the thrust axis points along acceleration + g;
/// with a zero axis the reference's attitude itself. The heading is the reference's (Lee, Leok and McClamroch
/// 2010 give b1 instead, which is singular when it points along the thrust). feedback_jerk [m/s^3]: rate of
/// the part of `acceleration` [m/s^2] that is not the reference's. The thrust never vanishes: a fall faster
/// than 0.7 g is not asked for.
AttitudeTarget attitude_target(const Reference& reference, const Vec3& acceleration_W,
                               const Vec3& feedback_jerk_W, const LawConfig& config);

/// What the vehicle does now of its last demand [m/s^2]: the thrust along its axis. Lets a law lead the
/// attitude.
Vec3 acceleration_now(const Vec3& last_demand_W, const RigidState& state, const LawConfig& config);

/// Rotation error 2 sin(angle/2) axis, body axes: restoring and of full size up to half a turn, where
/// attitude_error vanishes (Lee 2012, "Exponential stability of an attitude tracking control system on SO(3)
/// for large-angle rotational maneuvers"). At exactly half a turn either way round is as good; one is taken.
Vec3 half_angle_error(const Quat& q_WB, const Quat& q_WD);

/// Rate of the target [rad/s] in the axes of the body.
Vec3 target_rate(const AttitudeTarget& target, const RigidState& state);

/// What a law asks for, m/s^2 world and rad/s^2 body: the target's acceleration, and `turn` with, where
/// feed_forward is set, the angular acceleration that holds a body on the target while it is on it.
Vec6 demand(const AttitudeTarget& target, const Vec3& turn, const RigidState& state, bool feed_forward);

/// What a miss of the last demand [m/s^2 world, rad/s^2 body] tells the integrators: of an underactuated
/// vehicle only the part along its thrust axis, since it gets the rest by leaning.
Vec6 relevant_miss(const Vec6& unachieved, const RigidState& state, const LawConfig& config);

inline Vec3 clamp_each(const Vec3& v, double limit) { return v.cwiseMax(-limit).cwiseMin(limit); }

/// Which axes of a demand were cut to its bounds; all of them where `all` is set.
inline std::array<bool, 3> cut_axes(const Vec3& wanted, const Vec3& limited, bool all = false) {
  return {all || wanted.x() != limited.x(), all || wanted.y() != limited.y(),
          all || wanted.z() != limited.z()};
}

/// Integrals of an error over three axes that stand still where they would wind up.
class BoundedIntegral {
 public:
  /// gain: of the integral in the demand; limit: of gain times integral; tolerance: of a missed demand.
  BoundedIntegral(const Vec3& gain, double limit, double tolerance)
      : gain_(gain), limit_(limit), tolerance_(tolerance) {}
  /// An axis stands still while its demand is cut, or was missed by more than the tolerance, and its error
  /// asks for more of it.
  void update(const Vec3& error, double dt, const Vec3& missed, const std::array<bool, 3>& cut);
  Vec3 action() const { return gain_.cwiseProduct(value_); }
  void reset() { value_.setZero(); }

 private:
  Vec3 gain_;
  double limit_, tolerance_;
  Vec3 value_ = Vec3::Zero();
};

/// The integrals of a law, of its position and of its attitude loop.
struct LoopIntegrals {
  BoundedIntegral position, attitude;
  LoopIntegrals(const Vec3& position_gain, const Vec3& attitude_gain, const ControllerConfig& limits)
      : position(position_gain, limits.max_integral_acceleration, limits.unachieved_tolerance),
        attitude(attitude_gain, limits.max_integral_angular_acceleration,
                 limits.unachieved_angular_tolerance) {}
  /// m/s^2 world, rad/s^2 body.
  Vec6 action() const;
  void reset() { position.reset(), attitude.reset(); }
};

}  // namespace omniflight::control
