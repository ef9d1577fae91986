// Shapes that a leg's path may take before it is timed.
#pragma once

#include "ride_leg.hpp"

namespace omniflight::planning {

/// Shapes of a leg for curves through it, rounder or closer to the path.
std::vector<Path> shapes_of(const std::vector<Path>& paths);

/// Says that no shape of a leg is free.
inline constexpr const char* kBlocked =
    "curve_blocked: the timed curve does not keep the clearance of the path";

}  // namespace omniflight::planning
