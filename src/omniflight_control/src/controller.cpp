#include "omniflight_control/controller.hpp"

#include <algorithm>

namespace omniflight::control {
namespace {
Vec3 clamp(const Vec3& v, double limit) { return v.cwiseMax(-limit).cwiseMin(limit); }
}  // namespace

Vec3 attitude_error(const Quat& q_WB, const Quat& q_WD) {
  // 1/2 vee(R_e - R_e^T) with R_e = R^T R_d equals sin(angle) * axis of the error rotation
  return vee((q_WB.conjugate() * q_WD).toRotationMatrix());
}

Vec6 Controller::integral_action() const {
  Vec6 out;
  out << clamp(config_.ki.cwiseProduct(integral_.head<3>()), config_.max_integral_acceleration),
      clamp(config_.kI.cwiseProduct(integral_.tail<3>()), config_.max_integral_angular_acceleration);
  return out;
}

Vec6 Controller::answer(const Reference& r, const RigidState& s, double dt, const Vec6& unachieved) {
  const Mat3 R_BD = (s.q_WB.conjugate() * r.q_WB).toRotationMatrix();
  const Vec3 e_p = r.p_WB - s.p_WB;
  const Vec3 e_R = vee(R_BD);
  Vec6 feedback;
  feedback << config_.kv.cwiseProduct(r.v_WB_W - s.v_WB_W) + config_.kp.cwiseProduct(e_p),
      config_.kw.cwiseProduct(R_BD * r.w_WB_B - s.w_WB_B) + config_.kR.cwiseProduct(e_R);
  feedback += integral_action();
  Vec6 limited;
  limited << clamp(feedback.head<3>(), config_.max_acceleration),
      clamp(feedback.tail<3>(), config_.max_angular_acceleration);

  for (int k = 0; k < 6 && dt > 0.0; ++k) {
    const double gain = k < 3 ? config_.ki[k] : config_.kI[k - 3];
    if (gain <= 0.0) continue;
    const double error = k < 3 ? e_p[k] : e_R[k - 3];
    const double missed = unachieved[k];
    const double tolerance = k < 3 ? config_.unachieved_tolerance : config_.unachieved_angular_tolerance;
    if (std::abs(missed) > tolerance && missed * error > 0.0) continue;  // it cannot give more that way
    const bool relieves = integral_[k] * error < 0.0;
    if (limited[k] != feedback[k] && !relieves) continue;
    const double limit =
        (k < 3 ? config_.max_integral_acceleration : config_.max_integral_angular_acceleration) / gain;
    integral_[k] = std::clamp(integral_[k] + error * dt, -limit, limit);
  }
  if (config_.feed_forward) {
    limited.head<3>() += r.a_WB_W;
    limited.tail<3>() += R_BD * r.dw_WB_B;
  }
  return limited;
}

}  // namespace omniflight::control
