// Numbers on the telekyb3 wire and their SI meaning.
// The boards carry rotor speed as a signed half-period in whole microseconds: 120 Hz becomes 120.019 Hz, and
// the step grows with the square of the speed (0.029 Hz at 120 Hz, 0.18 Hz at 300 Hz). One Hz is 2 pi rad/s.
#pragma once

#include <cstdint>
#include <omniflight_core/frames.hpp>

namespace omniflight::gateway {

/// Half-period that means "idle, no commanded speed"; both signs.
inline constexpr std::int16_t kStopHalfPeriod = 32767;
/// Slowest speed the wire can carry: 1e6 / 2 / 32767 = 15.259 Hz, in rad/s. Slower commands mean stop.
inline constexpr double kSlowestSpeed = 2 * kPi * 1e6 / 2 / kStopHalfPeriod;

/// Half-period [us] of a rotor speed [rad/s, signed], truncated towards zero as the boards' host software
/// does. |speed| below 15.259 Hz gives +-32767 (stop); NaN gives +32767; faster than 500 kHz gives +-1.
std::int16_t half_period_from_speed(double speed_radps);
/// Rotor speed [rad/s, signed] of a half-period [us]; 0 and +-32767 (and -32768) give 0.
double speed_from_half_period(std::int16_t half_period_us);

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
