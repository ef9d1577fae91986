// Which part of a flight is judged and where a rotor is at its limit: the same over a bus and in one process.
#pragma once

#include <optional>
#include <utility>

#include "omniflight_core/trajectory.hpp"

namespace omniflight::campaign {

inline constexpr double kAtLimit = 0.995;  ///< share of a rotor's largest thrust that counts as its limit
inline constexpr double kAtEnd = 0.25;     ///< s before the plan's end within which it must be reached

/// First and last time [s] at which the plan moves; nothing when it only holds.
std::optional<std::pair<double, double>> motion_of(const Trajectory& trajectory);

}  // namespace omniflight::campaign
