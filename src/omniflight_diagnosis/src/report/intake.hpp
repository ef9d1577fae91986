// The part of a diagnosis that is known before anything is fitted.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Signals, clocks and notes of one flight.
Intake describe(const recording::Recording& recording, const Flight& flight);

}  // namespace omniflight::diagnosis
