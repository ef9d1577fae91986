// Rotor speed as electronic speed controllers time and command it: half a period in whole microseconds.
// 120 Hz becomes 120.019 Hz, and the step grows with the square of the speed (0.029 Hz at 120 Hz, 0.18 Hz at
// 300 Hz). One Hz is 2 pi rad/s.
#pragma once

#include <cstdint>

#include "omniflight_core/frames.hpp"

namespace omniflight {

/// Half-period that means "idle, no commanded speed"; both signs.
inline constexpr std::int16_t kStopHalfPeriod = 32767;
/// Slowest speed that an int16 half-period can carry: 1e6 / 2 / 32767 = 15.259 Hz, in rad/s. Slower is stop.
inline constexpr double kSlowestSpeed = 2 * kPi * 1e6 / 2 / kStopHalfPeriod;

/// Half-period [us] of a rotor speed [rad/s, signed], truncated towards zero as the boards' host software
/// does. |speed| below kSlowestSpeed gives +-32767 (stop); NaN gives +32767; faster than 500 kHz gives +-1.
std::int16_t half_period_from_speed(double speed_radps);
/// Rotor speed [rad/s, signed] of a half-period [us]; 0 and +-32767 (and -32768) give 0.
double speed_from_half_period(std::int16_t half_period_us);

}  // namespace omniflight
