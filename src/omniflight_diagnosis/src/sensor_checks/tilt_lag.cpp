#include "tilt_lag.hpp"

#include <algorithm>
#include <cmath>

#include "../conditioning/tilt_servo.hpp"
#include "omniflight_physics/tilt_servo.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Signal;

constexpr double kLagStep = 0.0025;  // s, grid of lags tried; chosen
constexpr int kLagSteps = 200;       // beyond the told lag: up to 0.5 s more

/// Lag [s] with the least squared error between the servo model and the tilt within [from, to) [s].
double lag_in_block(const Signal& tilt, const Eigen::MatrixXd& ordered, vehicle::Tilt servo, double from,
                    double to) {
  double best = 1e300, chosen = 0;
  const int most = kLagSteps + static_cast<int>(servo.time_constant / kLagStep);
  for (int k = 0; k <= most; ++k) {
    servo.time_constant = kLagStep * k;
    physics::TiltServo x(servo, ordered(0, 0));
    double left = 0;
    for (Eigen::Index i = 1; i < tilt.values.rows(); ++i) {
      const double t = tilt.t_s[static_cast<std::size_t>(i)];
      if (t >= to) break;
      if (const double u = ordered(i, 0); std::isfinite(u))
        x.step(u, t - tilt.t_s[static_cast<std::size_t>(i) - 1]);
      if (t >= from) left += std::pow(tilt.values(i, 0) - x.alpha(), 2);
    }
    if (left < best) best = left, chosen = servo.time_constant;
  }
  return chosen;
}

}  // namespace

TiltLags tilt_lags(const recording::Recording& r, const vehicle::Tilt& told, double block_s) {
  TiltLags out;
  const Signal *tilt = r.find("alpha"), *command = r.find("alpha_command");
  if (!tilt || !command || tilt->size() < 100 || command->empty()) return out;
  if (tilt->width() != 1 || command->width() != 1) return out;
  const Eigen::MatrixXd ordered = recording::resample(*command, tilt->t_s, kLongestTiltHold);
  if (!std::isfinite(ordered(0, 0))) return out;
  vehicle::Tilt servo = told;
  if (!shows_told_servo(r, told)) servo.time_constant = servo.backlash = 0;
  out.told = servo.time_constant;
  const double from = tilt->t_s.front(), span = tilt->t_s.back() - from;
  const int blocks = std::clamp(static_cast<int>(span / block_s), 1, 20);
  for (int b = 0; b < blocks; ++b) {
    const double a = from + span * b / blocks, z = from + span * (b + 1) / blocks;
    double low = 1e300, high = -1e300;
    for (Eigen::Index i = 0; i < ordered.rows(); ++i)
      if (const double t = tilt->t_s[static_cast<std::size_t>(i)];
          t >= a && t < z && std::isfinite(ordered(i, 0)))
        low = std::min(low, ordered(i, 0)), high = std::max(high, ordered(i, 0));
    if (high - low > kLeastTiltMove) out.lag.push_back(lag_in_block(*tilt, ordered, servo, a, z));
  }
  return out;
}

}  // namespace omniflight::diagnosis
