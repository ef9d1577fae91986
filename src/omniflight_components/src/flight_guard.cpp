#include "flight_guard.hpp"

namespace omniflight::components {

using safety::Action;
using safety::Fault;

namespace {
/// s that inertial samples may be ahead of the newest tick or behind it. Both come from the plant, which
/// sends what it gathered while the machine slept before the next tick.
constexpr double kImuStampReach = 1.0;
}  // namespace

Result<GuardConfig> read_guard(bus::Parameters& p) {
  GuardConfig c;
  safety::Limits& l = c.limits;
  // the ladder counts from when the pose is stale; the parameter from the last pose
  const double pose = p.number("mocap_timeout_s", 0.5, 0.01, 10);
  const double imu = p.number("imu_timeout_s", 0.1, 0.01, 10);
  constexpr double kPoseShare = 0.6, kImuShare = 0.5;  // of it until it counts as lost, as in safety::Limits
  l.pose_stale_s = kPoseShare * pose;
  l.imu_stale_s = kImuShare * imu;
  c.ladder.rungs[index(Fault::pose_lost)].delay_s = pose - l.pose_stale_s;
  c.ladder.rungs[index(Fault::imu_lost)].delay_s = imu - l.imu_stale_s;
  const auto corner = [&](const char* key, const Vec3& otherwise) {
    const auto v = p.numbers(key, std::vector<double>{otherwise.x(), otherwise.y(), otherwise.z()}, 3);
    return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : otherwise;
  };
  l.fence.min = corner("fence_min_m", l.fence.min);
  l.fence.max = corner("fence_max_m", l.fence.max);
  l.fence.margin = p.number("fence_margin_m", l.fence.margin, 0, 100);
  l.battery_low_V = p.number("battery_low_V", 0.0, 0, 1000);
  l.battery_empty_V = p.number("battery_empty_V", 0.0, 0, 1000);
  l.innovation_m = p.number("diverged_m", l.innovation_m, 0.01, 100);
  l.missed_share = p.number("missed_share", l.missed_share, 0, 1);
  c.descend_speed = p.number("descend_speed_mps", c.descend_speed, 0.01, 5);
  c.landing.ground_z = p.number("ground_z_m", c.landing.ground_z, -1e4, 1e4);
  c.landing.touchdown = p.number("touchdown_m", c.landing.touchdown, 0.001, 10);
  c.landing.contact = p.number("contact_m", c.landing.contact, 0.001, 10);
  c.poses.jump_m = p.number("pose_jump_m", c.poses.jump_m, 0.01, 100);
  c.poses.jump_rad = p.number("pose_jump_rad", c.poses.jump_rad, 0.01, 4);
  c.poses.stamps.future_s = p.number("pose_future_s", c.poses.stamps.future_s, 0, 9);
  c.imu_stamps.future_s = c.imu_stamps.old_s = kImuStampReach;
  if (auto ok = safety::check(c.ladder); !ok) return Failure(ok.error());
  if (!((l.fence.max - l.fence.min).minCoeff() > 0))
    return bad_input("must be below fence_max_m on every axis [m]", "controller.fence_min_m",
                     "Take the bounds of the test bed");
  return c;
}

bool FlightGuard::place_imu(double stamp_s, double now_s, double& flight_s) {
  if (!imu_clock_.place(stamp_s, now_s, flight_s)) return true;
  ++refused_imu_;
  return false;
}

bool FlightGuard::believes(double stamp_s, const Vec3& p_WB, const Quat& q_WB, double now_s, bool free,
                           const control::StateEstimator& estimator) {
  std::optional<safety::ExpectedPose> expected;
  if (estimator.ready()) expected = {estimator.state().p_WB, estimator.state().q_WB};
  return !poses_.judge(stamp_s, p_WB, q_WB, now_s, free, expected);
}

bool FlightGuard::update(double now_s, const control::StateEstimator& estimator, safety::Wish wish) {
  const Action before = action();
  if (!state_.armed) {
    auto armed = safety::arm(config_.ladder, state_, now_s, {});
    if (armed) state_ = *armed;
  }
  safety::Vitals v;
  v.pose_age_s = now_s - estimator.last_mocap();
  v.imu_age_s = now_s - estimator.time();
  v.innovation_m = poses_.apart_m();
  v.missed_share = missed_.share();
  v.p_W = estimator.state().p_WB;
  v.wish = wish;
  v.battery_V = battery_V_;
  constexpr double kHeard = 0.02;  // s
  v.hover_load = now_s >= loss_.at_s + kHeard ? loss_.hover_load : 0.0;
  if (before == Action::descend) landing_.look(estimator.state());
  const bool landed = landing_.landed(estimator.state().p_WB);
  state_ = safety::step(config_.ladder, state_, now_s, safety::judge(config_.limits, v), landed);
  if (before == Action::hold) paused_s_ += now_s - last_s_;
  last_s_ = now_s;
  return action() != before;
}

Reference FlightGuard::reference(const Trajectory& plan, double along, double now_s,
                                 const RigidState& estimate) {
  if (action() == Action::fly) {
    frozen_.reset();
    return plan.sample(along);
  }
  if (!frozen_) {
    frozen_ = plan.sample(along);
    frozen_s_ = now_s;
    frozen_->v_WB_W = frozen_->w_WB_B = frozen_->a_WB_W = frozen_->dw_WB_B = Vec3::Zero();
  }
  if (action() == Action::hold) {
    frozen_s_ = now_s;
    return *frozen_;
  }
  if (frozen_->v_WB_W.isZero()) {  // a descent begins where the vehicle is
    frozen_->p_WB.z() = estimate.p_WB.z();
    frozen_->v_WB_W.z() = -config_.descend_speed;
    landing_.begin(estimate, alpha_);
    descending_ = action() == Action::descend;
  }
  Reference r = *frozen_;
  const double z = r.p_WB.z() - config_.descend_speed * (now_s - frozen_s_);
  r.p_WB.z() = std::max(z, landing_.lowest());
  if (z < landing_.lowest()) r.v_WB_W = Vec3::Zero();
  return r;
}

std::string FlightGuard::words() const {
  std::string out(safety::to_string(action()));
  if (state_.armed && state_.cause) out += ": " + std::string(safety::to_string(*state_.cause));
  return out;
}

}  // namespace omniflight::components
