#include "omniflight_control/leaning_gains.hpp"

#include <algorithm>

namespace omniflight::control {

ControllerConfig leaning_gains(double motor_time_constant, bool led) {
  const double fastest = 12.25;  // rad/s
  const double r = std::min(1.0, kLagShare / std::max(1e-3, motor_time_constant) / fastest);
  ControllerConfig out;
  out.kp = Vec3::Constant((led ? 8 : 4) * r * r);
  out.kv = Vec3::Constant((led ? 5 : 3.5) * r);
  out.ki = Vec3::Constant((led ? 4 : 2) * r * r * r);
  out.kR = Vec3::Constant(150 * r * r);
  out.kw = Vec3::Constant(22 * r);
  return out;
}

}  // namespace omniflight::control
