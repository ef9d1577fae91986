// Cascaded loops, as flight boards have them: position P, velocity PI, attitude P, rate PI, each with a limit
// of its own. The gains are those of the other laws: kp = (position gain) (velocity gain), kR = (attitude
// gain) (rate gain).
#include "attitude_target.hpp"
#include "laws.hpp"

namespace omniflight::control {
namespace {

/// Gain of the outer loop [1/s] that gives `stiffness` [1/s^2] with the inner loop's `damping` [1/s].
Vec3 outer_gain(const Vec3& stiffness, const Vec3& damping) {
  return stiffness.cwiseQuotient(damping.cwiseMax(1e-6));
}
/// Gain of the inner integral [1/s^2] that gives `integral` [1/s^3] on the outer error.
Vec3 inner_integral(const Vec3& integral, const Vec3& outer) {
  return integral.cwiseQuotient(outer.cwiseMax(1e-6));
}

class Cascaded final : public Law {
 public:
  explicit Cascaded(const LawConfig& config)
      : config_(config),
        k_position_(outer_gain(config.gains.kp, config.gains.kv)),
        k_attitude_(outer_gain(config.gains.kR, config.gains.kw)),
        integrals_(inner_integral(config.gains.ki, k_position_), inner_integral(config.gains.kI, k_attitude_),
                   config.gains) {}

  Vec6 integral_action() const override { return integrals_.action(); }

 private:
  Vec6 answer(const Reference& r, const RigidState& s, double dt, const Vec6& unachieved) override {
    const ControllerConfig& g = config_.gains;
    const Vec3 correction =
        clamp_each(k_position_.cwiseProduct(r.p_WB - s.p_WB), config_.max_correction_speed);
    const Vec3 e_v = r.v_WB_W + correction - s.v_WB_W;
    const Vec3 feedback = g.kv.cwiseProduct(e_v) + integrals_.position.action();
    const Vec3 limited = clamp_each(feedback, g.max_acceleration);
    const Vec3 forward = g.feed_forward ? r.a_WB_W : Vec3::Zero();
    const AttitudeTarget target = attitude_target(r, limited + forward, Vec3::Zero(), config_);

    const Vec3 e_R = half_angle_error(s.q_WB, target.q_WD);
    const Vec3 e_w = target_rate(target, s) +
                     clamp_each(k_attitude_.cwiseProduct(e_R), config_.max_correction_rate) - s.w_WB_B;
    const Vec3 turn = g.kw.cwiseProduct(e_w) + integrals_.attitude.action();
    const Vec3 turn_limited = clamp_each(turn, g.max_angular_acceleration);

    const Vec6 missed = relevant_miss(unachieved, s, config_);
    integrals_.position.update(e_v, dt, missed.head<3>(), cut_axes(feedback, limited, target.limited));
    integrals_.attitude.update(e_w, dt, missed.tail<3>(), cut_axes(turn, turn_limited));
    return demand(target, turn_limited, s, g.feed_forward);
  }

  void forget() override { integrals_.reset(); }

  LawConfig config_;
  Vec3 k_position_, k_attitude_;  ///< 1/s
  LoopIntegrals integrals_;       ///< of velocity and rate errors: m, rad
};

}  // namespace

std::unique_ptr<Law> make_cascaded(const LawConfig& config) { return std::make_unique<Cascaded>(config); }

}  // namespace omniflight::control
