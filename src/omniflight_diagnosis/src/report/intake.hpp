// Intake: contents of a recording before anything is fitted.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Signals, sensor statistics, missing signals, alignment and notes; excitation and detectability are left
/// empty.
Intake describe(const recording::Recording& recording, const Flight& flight);

}  // namespace omniflight::diagnosis
