// Incremental nonlinear dynamic inversion: the demand is the last one plus what is missing of the wanted
// acceleration in the measured one (Smeur, Chu and de Croon 2016, "Adaptive incremental nonlinear dynamic
// inversion for attitude control of micro air vehicles"; Tal and Karaman 2021). Written with both
// accelerations behind one low pass: the difference of what was commanded and what was measured is the
// disturbance, and is taken out of the demand.
#include "attitude_target.hpp"
#include "laws.hpp"

namespace omniflight::control {
namespace {

class Incremental final : public Law {
 public:
  explicit Incremental(const LawConfig& config) : config_(config) {}

  /// What is added to the demand against the disturbance, bounded as the integral action of the other laws
  /// is.
  Vec6 integral_action() const override {
    Vec6 out;
    out << clamp_each(disturbance_.head<3>(), config_.gains.max_integral_acceleration),
        clamp_each(disturbance_.tail<3>(), config_.gains.max_integral_angular_acceleration);
    return out;
  }

 private:
  Vec6 answer(const Reference& r, const RigidState& s, double dt, const Vec6& unachieved) override {
    const ControllerConfig& g = config_.gains;
    observe(s, dt, unachieved);
    const Vec3 e_p = r.p_WB - s.p_WB, e_v = r.v_WB_W - s.v_WB_W;
    const Vec3 limited = clamp_each(g.kp.cwiseProduct(e_p) + g.kv.cwiseProduct(e_v), g.max_acceleration);
    const Vec3 wanted = limited + (g.feed_forward ? r.a_WB_W : Vec3::Zero());
    const Vec6 taken_out = integral_action();
    const Vec3 now = acceleration_now(demand_.head<3>(), s, config_) - taken_out.head<3>();
    const Vec3 jerk = g.kp.cwiseProduct(e_v) + g.kv.cwiseProduct(r.a_WB_W - now);
    const AttitudeTarget target = attitude_target(r, wanted + taken_out.head<3>(), jerk, config_);

    const Vec3 e_R = half_angle_error(s.q_WB, target.q_WD);
    const Vec3 turn =
        clamp_each(g.kR.cwiseProduct(e_R) + g.kw.cwiseProduct(target_rate(target, s) - s.w_WB_B),
                   g.max_angular_acceleration);
    demand_ = demand(target, turn, s, g.feed_forward);
    demand_.tail<3>() += taken_out.tail<3>();
    asked_ = true;
    return demand_;
  }

  void forget() override {
    disturbance_.setZero();
    acting_.setZero();
    demand_.setZero();
    asked_ = started_ = false;
  }

  /// The command acts with the actuators' lag, in the body: its direction turns with the vehicle at once. The
  /// velocities' differences are the measured accelerations.
  void observe(const RigidState& s, double dt, const Vec6& unachieved) {
    const Vec3 g = kGravity * Vec3::UnitZ();
    if (asked_ && dt > 0.0) {
      const Vec6 achieved = demand_ - unachieved;
      Vec6 commanded;
      commanded << state_.q_WB.conjugate() * (achieved.head<3>() + g), achieved.tail<3>();
      const double lag = config_.actuator_time_constant;
      if (!started_) acting_ = commanded;
      acting_ += (lag > 0 ? 1.0 - std::exp(-dt / lag) : 1.0) * (commanded - acting_);
      if (started_) {
        Vec6 difference;
        difference << state_.q_WB.slerp(0.5, s.q_WB) * acting_.head<3>() - g -
                          (s.v_WB_W - state_.v_WB_W) / dt,
            acting_.tail<3>() - (s.w_WB_B - state_.w_WB_B) / dt;
        disturbance_ += (1.0 - std::exp(-config_.disturbance_bandwidth * dt)) * (difference - disturbance_);
      }
      started_ = true;
    }
    state_ = s;
  }

  LawConfig config_;
  Vec6 demand_ = Vec6::Zero();       ///< m/s^2 world, rad/s^2 body
  Vec6 acting_ = Vec6::Zero();       ///< N/kg and rad/s^2, body: the last commands as they act
  RigidState state_;                 ///< of the period before
  Vec6 disturbance_ = Vec6::Zero();  ///< commanded less measured acceleration: m/s^2 world, rad/s^2 body
  bool asked_ = false, started_ = false;
};

}  // namespace

std::unique_ptr<Law> make_incremental(const LawConfig& config) {
  return std::make_unique<Incremental>(config);
}

}  // namespace omniflight::control
