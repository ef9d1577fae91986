#include "omniflight_core/half_period.hpp"

namespace omniflight {
namespace {
constexpr double kHalfMicros = 1e6 / 2;  // us of half-period at 1 Hz
}

std::int16_t half_period_from_speed(double speed_radps) {
  const double hertz = speed_radps / (2 * kPi);
  if (!(std::abs(hertz) * kStopHalfPeriod >= kHalfMicros)) {
    return hertz < 0 ? static_cast<std::int16_t>(-kStopHalfPeriod) : kStopHalfPeriod;
  }
  // The guard keeps a speed that came from a half-period at that half-period.
  constexpr double kRoundingGuard = 1e-6;
  const double half_period = std::max(1.0, std::trunc(kHalfMicros / std::abs(hertz) + kRoundingGuard));
  return static_cast<std::int16_t>(std::copysign(half_period, hertz));
}

double speed_from_half_period(std::int16_t half_period_us) {
  if (half_period_us == 0 || half_period_us >= kStopHalfPeriod || half_period_us <= -kStopHalfPeriod)
    return 0.0;
  return 2 * kPi * kHalfMicros / half_period_us;
}

}  // namespace omniflight
