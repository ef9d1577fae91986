// Accelerations that the control allocation could not realise.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Compares requested (`qddr`) with allocated (`qdd`) acceleration: m/s^2 in world, rad/s^2 in body axes.
/// Returns the channels whose RMS difference exceeds 0.05 plus 10 % of the RMS request (chosen). Empty where
/// not logged.
std::vector<Mismatch> locate_allocation(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
