#include "attitude_target.hpp"

namespace omniflight::control {
namespace {

constexpr double kLeastLift = 0.3;  // of g, that the demand keeps upward

}  // namespace

AttitudeTarget attitude_target(const Reference& r, const Vec3& acceleration_W, const Vec3& feedback_jerk_W,
                               const LawConfig& config) {
  AttitudeTarget out;
  out.q_WD = r.q_WB;
  out.w_WD_D = r.w_WB_B;
  out.dw_WD_D = r.dw_WB_B;
  out.acceleration_W = acceleration_W;
  if (config.thrust_axis_B.isZero()) return out;

  Vec3 thrust = acceleration_W + kGravity * Vec3::UnitZ();  // N/kg
  const double lift = std::max(thrust.z(), kLeastLift * kGravity);
  const double aside = thrust.head<2>().norm(), most = lift * std::tan(config.max_lean);
  out.limited = lift > thrust.z() || aside > most;
  thrust.z() = lift;
  if (aside > most) thrust.head<2>() *= most / aside;
  out.acceleration_W = thrust - kGravity * Vec3::UnitZ();

  const Vec3 n_ref = r.q_WB * config.thrust_axis_B, n = thrust.normalized();
  const Vec3 w_ref_W = r.q_WB * r.w_WB_B;
  out.q_WD = (shortest_rotation(n_ref, n) * r.q_WB).normalized();
  // the direction turns with the reference's thrust and with the feedback; the spin about it is the
  // reference's
  const double thrust_ref = (r.a_WB_W + kGravity * Vec3::UnitZ()).norm();
  Vec3 rate = thrust_ref * w_ref_W.cross(n_ref);
  if (!out.limited) rate += feedback_jerk_W;
  const Vec3 w_W = n.cross(rate) / thrust.norm() + n_ref.dot(w_ref_W) * n;
  out.w_WD_D = out.q_WD.conjugate() * w_W;
  return out;
}

Vec3 acceleration_now(const Vec3& last_demand_W, const RigidState& state, const LawConfig& config) {
  if (config.thrust_axis_B.isZero()) return last_demand_W;
  const Vec3 n = state.q_WB * config.thrust_axis_B, g = kGravity * Vec3::UnitZ();
  return n * n.dot(last_demand_W + g) - g;
}

Vec3 half_angle_error(const Quat& q_WB, const Quat& q_WD) {
  const Quat q = q_WB.conjugate() * q_WD;
  return (q.w() < 0 ? -2.0 : 2.0) * q.vec();
}

Vec3 target_rate(const AttitudeTarget& target, const RigidState& state) {
  return state.q_WB.conjugate() * (target.q_WD * target.w_WD_D);
}

Vec6 demand(const AttitudeTarget& target, const Vec3& turn, const RigidState& state, bool feed_forward) {
  Vec6 out;
  out << target.acceleration_W, turn;
  if (!feed_forward) return out;
  const Quat q_BD = state.q_WB.conjugate() * target.q_WD;
  out.tail<3>() += q_BD * target.dw_WD_D - state.w_WB_B.cross(q_BD * target.w_WD_D);
  return out;
}

Vec6 relevant_miss(const Vec6& unachieved, const RigidState& state, const LawConfig& config) {
  Vec6 out = unachieved;
  if (config.thrust_axis_B.isZero()) return out;
  const Vec3 n = state.q_WB * config.thrust_axis_B;
  out.head<3>() = n * n.dot(unachieved.head<3>());
  return out;
}

Vec6 LoopIntegrals::action() const {
  Vec6 out;
  out << position.action(), attitude.action();
  return out;
}

void BoundedIntegral::update(const Vec3& error, double dt, const Vec3& missed,
                             const std::array<bool, 3>& cut) {
  if (!(dt > 0.0)) return;
  for (int k = 0; k < 3; ++k) {
    if (gain_[k] <= 0.0) continue;
    if (std::abs(missed[k]) > tolerance_ && missed[k] * error[k] > 0.0)
      continue;  // no more can be had that way
    if (cut[static_cast<std::size_t>(k)] && value_[k] * error[k] >= 0.0) continue;
    value_[k] = std::clamp(value_[k] + error[k] * dt, -limit_ / gain_[k], limit_ / gain_[k]);
  }
}

}  // namespace omniflight::control
