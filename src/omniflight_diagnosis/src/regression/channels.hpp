// Names and units of the six channels of the wrench in body axes.
#pragma once

#include <array>
#include <string>

namespace omniflight::diagnosis {

inline constexpr std::array<const char*, 6> kChannels{"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
inline const char* channel_unit(int channel) { return channel < 3 ? "N" : "Nm"; }

/// Unit of a coefficient of a regressor with this unit: "N", "N/m", "Nm/(rad/s)", "N/(m/s)2".
inline std::string unit_per(int channel, const std::string& unit) {
  if (unit == "1") return channel_unit(channel);
  const bool simple = unit.front() == '(' || unit.find_first_of(" /") == std::string::npos;
  return std::string(channel_unit(channel)) + (simple ? "/" + unit : "/(" + unit + ")");
}

}  // namespace omniflight::diagnosis
