#include "omniflight_control/state_estimator.hpp"

#include <cmath>

#include "within.hpp"

namespace omniflight::control {

bool is_usable(double t, const Vec3& specific_force_B, const Vec3& gyro_B) {
  return std::abs(t) <= SensorLimits::time && within(specific_force_B, SensorLimits::specific_force) &&
         within(gyro_B, SensorLimits::rate);
}

bool is_usable(double t, const Vec3& p_WB, const Quat& q_WB) {
  const double length = q_WB.norm();
  return std::abs(t) <= SensorLimits::time && within(p_WB, SensorLimits::position) && length >= 0.5 &&
         length <= 2.0;
}

}  // namespace omniflight::control
