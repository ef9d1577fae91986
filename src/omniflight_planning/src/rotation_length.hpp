#pragma once

namespace omniflight::planning {

/// Length of path [m] that one radian of rotation counts for, where poses of a path are compared.
inline constexpr double kRotationLength = 0.3;

}  // namespace omniflight::planning
