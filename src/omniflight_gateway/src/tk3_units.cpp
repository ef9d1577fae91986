#include "omniflight_gateway/tk3_units.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::gateway {

std::int16_t to_lsb(double value, double lsb) {
  if (std::isnan(value)) return 0;
  return static_cast<std::int16_t>(std::clamp(std::round(value / lsb), -32768.0, 32767.0));
}

ImuScale chimera_imu_scale() { return {8 * kGravity / 32768, to_radians(1000) / 32768}; }

}  // namespace omniflight::gateway
