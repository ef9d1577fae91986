// An accelerometer away from the body's origin, read as if it were there.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// The recording with 'acc' less what an accelerometer at p_BI [m, body] reads beside one at the origin:
/// dw x p_BI + w x (w x p_BI), by the gyro and its differences over 10 ms (two samples, of a slow one).
/// Unchanged where p_BI is zero or there is no gyro.
recording::Recording at_origin(const recording::Recording& recording, const Vec3& p_BI);

}  // namespace omniflight::diagnosis
