#include "omniflight_identification/speed_loop.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_core/random.hpp"

namespace omniflight::identification {
namespace {

constexpr double kAway = 1e6;  // rad/s

/// The command of a sampled PIDN, as in response().
class Pidn {
 public:
  Pidn(const PidnGains& gains, double period_s, double limit, double start)
      : g_(gains), T_(period_s), limit_(limit), integral_(start) {}
  double update(double error) {
    if (g_.kd > 0) filtered_ = (filtered_ + g_.kd * g_.n * (error - before_)) / (1.0 + g_.n * T_);
    before_ = error;
    const double more = g_.ki * T_ * error, command = g_.kp * error + integral_ + more + filtered_;
    if (!(limit_ > 0)) {
      integral_ += more;
      return command;
    }
    // an integral that pushes further into a limit stands still
    if (!((command > limit_ && more > 0) || (command < 0 && more < 0))) integral_ += more;
    return std::clamp(command, 0.0, limit_);
  }

 private:
  PidnGains g_;
  double T_, limit_, integral_, filtered_ = 0.0, before_ = 0.0;
};

}  // namespace

Eigen::VectorXd simulated(const SpeedLoop& loop, const PidnGains& gains, const Eigen::VectorXd& set_point) {
  const double T = loop.control_period_s, late = loop.up.delay_s / T;
  const auto whole = static_cast<Eigen::Index>(std::floor(late));
  const double part = (late - static_cast<double>(whole)) * T;
  Random random(loop.seed, "speed loop");
  const Eigen::Index n = set_point.size();
  Eigen::VectorXd y(n), u(n);
  if (n == 0) return y;
  const double start = set_point[0] / loop.up.gain;
  Pidn controller(gains, T, loop.command_max, start);
  double speed = set_point[0];
  const auto command = [&](Eigen::Index t) { return t >= 0 ? u[t] : start; };
  const auto follow = [&](double target, double duration) {
    const double lag = target > speed ? loop.up.lag_s : loop.down.lag_s;
    speed = target + (speed - target) * std::exp(-duration / lag);
  };
  for (Eigen::Index t = 0; t < n; ++t) {
    if (t > 0) {
      follow(loop.up.gain * command(t - 2 - whole), part);
      follow(loop.up.gain * command(t - 1 - whole), T - part);
    }
    if (!(std::abs(speed) < kAway)) {
      y.tail(n - t).setConstant(kAway);
      return y;
    }
    y[t] = speed;
    u[t] = controller.update(set_point[t] - speed - loop.noise_radps * random.normal());
  }
  return y;
}

LoopScore score(const Eigen::VectorXd& set_point, const Eigen::VectorXd& speed) {
  LoopScore out;
  if (speed.size() == 0) return out;
  const Eigen::ArrayXd error = (set_point - speed).array().abs();
  out.mean_error = error.mean();
  out.max_error = error.maxCoeff();
  out.bounded = speed.cwiseAbs().maxCoeff() < kAway;
  return out;
}

}  // namespace omniflight::identification
