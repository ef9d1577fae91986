// The outline of a convex body seen along an axis, for drawings.
#pragma once

#include <utility>
#include <vector>

#include "omniflight_core/frames.hpp"

namespace omniflight::allocation {

/// Corners of the projection of the hull of `points` onto the axes `across` and `up` (0 x, 1 y, 2 z),
/// counterclockwise, in the unit of the points. Always three at least: the ends of a line or a point are
/// repeated; without points the origin.
std::vector<std::pair<double, double>> outline(const std::vector<Vec3>& points, int across, int up);

}  // namespace omniflight::allocation
