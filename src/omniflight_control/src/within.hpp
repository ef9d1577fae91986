// Bounds of inputs, axis by axis.
#pragma once

#include "omniflight_core/frames.hpp"

namespace omniflight::control {

/// False for what is not finite, too.
inline bool within(const Vec3& v, double most) { return (v.array().abs() <= most).all(); }

}  // namespace omniflight::control
