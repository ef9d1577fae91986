#include "omniflight_control/estimator.hpp"

#include <algorithm>

namespace omniflight::control {

void Estimator::add_imu(double t, const Vec3& force, const Vec3& gyro) {
  if (!is_usable(t, force, gyro) || (has_imu_ && t <= time_)) {
    ++refused_;
    return;
  }
  if (has_imu_ && ready_) {
    const double dt =
        std::min(t - time_, 0.05);  // a longer gap is bridged by motion capture, not by integration
    const Vec3 w = 0.5 * (gyro + last_gyro_) - gyro_bias_;
    const Quat q1 = (state_.q_WB * exp_rotation(w * dt)).normalized();
    const Vec3 gravity(0, 0, -config_.gravity);
    const Vec3 a = 0.5 * (state_.q_WB * last_force_ + q1 * force) + gravity;
    state_.p_WB += state_.v_WB_W * dt + 0.5 * a * dt * dt;
    state_.v_WB_W += a * dt;
    state_.q_WB = q1;
    state_.w_WB_B = gyro - gyro_bias_;
  }
  time_ = t;
  last_force_ = force;
  last_gyro_ = gyro;
  has_imu_ = true;
  if (ready_) past_[past_count_++ % kPast] = {t, state_.p_WB, state_.q_WB};
}

void Estimator::add_mocap(double t, const Vec3& p, const Quat& q_measured) {
  if (!is_usable(t, p, q_measured) || t <= mocap_time_) {
    ++refused_;
    return;
  }
  const Quat q = q_measured.normalized();
  const double interval = mocap_time_ < 0 ? 0.0 : std::min(t - mocap_time_, 0.1);
  mocap_time_ = t;
  if (!ready_) {
    state_ = {p, q, Vec3::Zero(), has_imu_ ? last_gyro_ : Vec3::Zero()};
    ready_ = true;
    return;
  }
  // the estimate of the instant the pose was taken
  Past then{time_, state_.p_WB, state_.q_WB};
  for (std::size_t k = 0; k < std::min(past_count_, kPast); ++k) {
    const Past& candidate = past_[(past_count_ - 1 - k) % kPast];
    if (candidate.t <= t + 1e-9) {
      then = candidate;
      break;
    }
  }
  // the part of the way between the estimate's sample and the pose's instant
  const double ahead = std::clamp(t - then.t, 0.0, 0.01);
  const Vec3 e_p = p - (then.p + state_.v_WB_W * ahead);
  const Vec3 e_R = log_rotation((then.q * exp_rotation(state_.w_WB_B * ahead)).conjugate() * q);
  const double zp = std::exp(-config_.position_bandwidth * interval);
  const double zR = std::exp(-config_.attitude_bandwidth * interval);
  state_.p_WB += (1.0 - zp * zp) * e_p;
  if (interval > 0.0) state_.v_WB_W += (1.0 - zp) * (1.0 - zp) / interval * e_p;
  state_.q_WB = (state_.q_WB * exp_rotation((1.0 - zR) * e_R)).normalized();
  gyro_bias_ -= config_.gyro_bias_gain * interval * e_R;
}

}  // namespace omniflight::control
