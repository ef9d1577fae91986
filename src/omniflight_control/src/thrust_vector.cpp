// Geometric tracking of a vehicle with one direction of force: Lee, Leok and McClamroch, "Geometric tracking
// control of a quadrotor UAV on SE(3)", CDC 2010, with integral action and the attitude error of Lee 2012.
#include "attitude_target.hpp"
#include "laws.hpp"

namespace omniflight::control {
namespace {

class ThrustVector final : public Law {
 public:
  explicit ThrustVector(const LawConfig& config)
      : config_(config), integrals_(config.gains.ki, config.gains.kI, config.gains) {}

  Vec6 integral_action() const override { return integrals_.action(); }

 private:
  Vec6 answer(const Reference& r, const RigidState& s, double dt, const Vec6& unachieved) override {
    const ControllerConfig& g = config_.gains;
    const Vec3 e_p = r.p_WB - s.p_WB, e_v = r.v_WB_W - s.v_WB_W;
    const Vec3 feedback = g.kp.cwiseProduct(e_p) + g.kv.cwiseProduct(e_v) + integrals_.position.action();
    const Vec3 limited = clamp_each(feedback, g.max_acceleration);
    const Vec3 forward = g.feed_forward ? r.a_WB_W : Vec3::Zero();
    const Vec3 now = acceleration_now(last_, s, config_);
    const Vec3 jerk = g.kp.cwiseProduct(e_v) + g.kv.cwiseProduct(r.a_WB_W - now) + g.ki.cwiseProduct(e_p);
    const AttitudeTarget target = attitude_target(r, limited + forward, jerk, config_);
    last_ = target.acceleration_W;

    const Vec3 e_R = half_angle_error(s.q_WB, target.q_WD);
    const Vec3 turn = g.kR.cwiseProduct(e_R) + g.kw.cwiseProduct(target_rate(target, s) - s.w_WB_B) +
                      integrals_.attitude.action();
    const Vec3 turn_limited = clamp_each(turn, g.max_angular_acceleration);

    const Vec6 missed = relevant_miss(unachieved, s, config_);
    integrals_.position.update(e_p, dt, missed.head<3>(), cut_axes(feedback, limited, target.limited));
    integrals_.attitude.update(e_R, dt, missed.tail<3>(), cut_axes(turn, turn_limited));
    return demand(target, turn_limited, s, g.feed_forward);
  }

  void forget() override {
    integrals_.reset();
    last_.setZero();
  }

  LawConfig config_;
  LoopIntegrals integrals_;
  Vec3 last_ = Vec3::Zero();  ///< m/s^2, last demand
};

}  // namespace

std::unique_ptr<Law> make_thrust_vector(const LawConfig& config) {
  return std::make_unique<ThrustVector>(config);
}

}  // namespace omniflight::control
