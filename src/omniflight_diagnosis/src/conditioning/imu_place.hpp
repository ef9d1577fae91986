// Lever-arm correction of the accelerometer to the body origin.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// The recording with dw x p_BI + w x (w x p_BI) subtracted from 'acc', for an accelerometer at p_BI [m,
/// body]. w is the gyro, dw its central difference over 10 ms, or over two sample periods of a slower gyro.
/// Unchanged where p_BI is zero or there is no gyro.
recording::Recording at_origin(const recording::Recording& recording, const Vec3& p_BI);

}  // namespace omniflight::diagnosis
