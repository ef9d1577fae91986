#include "tilt_servo.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "omniflight_physics/tilt_servo.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

bool has_lag_or_play(const vehicle::Tilt& servo) { return servo.time_constant > 0 || servo.backlash > 0; }

double squared_distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double sum = 0;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    if (const double off = a[i] - b[i]; std::isfinite(off)) sum += off * off;
  return sum;
}

Signal answered(const vehicle::Tilt& servo, const Signal& input) {
  Signal out = input;
  out.name = "alpha";
  out.values.col(0) = answer_of_servo(servo, input.t_s, input.values.col(0));
  return out;
}

}  // namespace

Eigen::VectorXd answer_of_servo(const vehicle::Tilt& servo, const std::vector<double>& t,
                                const Eigen::VectorXd& input) {
  Eigen::VectorXd out = Eigen::VectorXd::Constant(input.size(), std::numeric_limits<double>::quiet_NaN());
  std::optional<physics::TiltServo> tilt;
  Eigen::Index before = 0;
  for (Eigen::Index i = 0; i < input.size(); ++i) {
    if (!std::isfinite(input[i])) continue;
    if (!tilt)
      tilt.emplace(servo, input[i]);
    else
      tilt->step(servo.time_constant > 0 ? 0.5 * (input[before] + input[i]) : input[i],
                 t[static_cast<std::size_t>(i)] - t[static_cast<std::size_t>(before)]);
    before = i;
    out[i] = tilt->alpha();
  }
  return out;
}

bool shows_told_servo(const Recording& r, const vehicle::Tilt& servo) {
  const Signal *alpha = r.find("alpha"), *command = r.find("alpha_command");
  if (!has_lag_or_play(servo) || !alpha || !command || alpha->width() != 1 || command->width() != 1)
    return true;
  const Eigen::VectorXd ordered = recording::resample(*command, alpha->t_s, kLongestTiltHold).col(0);
  const Eigen::VectorXd measured = alpha->values.col(0);
  double low = 1e300, high = -1e300;
  for (const double x : ordered)
    if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
  if (!(high - low > kLeastTiltMove)) return true;
  vehicle::Tilt echo = servo;
  echo.time_constant = echo.backlash = 0;
  return squared_distance(measured, answer_of_servo(servo, alpha->t_s, ordered)) <
         squared_distance(measured, answer_of_servo(echo, alpha->t_s, ordered));
}

std::optional<RotorTilt> rotor_tilt(const Recording& r, const vehicle::Vehicle& vehicle) {
  if (const Signal* alpha = r.find("alpha")) {
    if (shows_told_servo(r, vehicle.tilt)) return RotorTilt{*alpha, false};
    return RotorTilt{answered(vehicle.tilt, *alpha), true};
  }
  const Signal* command = r.find("alpha_command");
  if (!command || command->width() != 1 || vehicle.tilt.kind == vehicle::TiltKind::none) return std::nullopt;
  return RotorTilt{answered(vehicle.tilt, *command), true};
}

Eigen::MatrixXd tilt_at(const Recording& r, const vehicle::Vehicle& vehicle, const std::vector<double>& t) {
  const auto tilt = rotor_tilt(r, vehicle);
  return tilt ? recording::resample(tilt->alpha, t) : Eigen::MatrixXd();
}

}  // namespace omniflight::diagnosis
