// Numbers on the telekyb3 wire and their SI meaning.
// Rotor speed travels as a signed half-period, see omniflight_core/half_period.hpp.
#pragma once

#include <cstdint>
#include <omniflight_core/frames.hpp>
#include <omniflight_core/half_period.hpp>

namespace omniflight::gateway {

/// int16 nearest to value / lsb, saturated at the ends; NaN gives 0.
std::int16_t to_lsb(double value, double lsb);

/// What one count of the IMU means.
struct ImuScale {
  double acceleration = 1e-3;  ///< m/s^2 per count
  double gyro = 1e-3;          ///< rad/s per count
};
/// +-8 g and +-1000 deg/s over 16 bit.
ImuScale chimera_imu_scale();

inline constexpr double kMagneticLsb = 1e-8;     ///< T
inline constexpr double kThrottleFull = 1023.0;  ///< counts at 100 %
inline constexpr double kPidScale = 10000.0;     ///< counts per unit gain
inline constexpr double kMilli = 1e-3;           ///< battery V and motor A per count

}  // namespace omniflight::gateway
