// Limits of the rotors that the vehicle file does not know, as findings.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Findings actuator_saturation (below the largest speed of the vehicle file) and thrust_dead_zone, with
/// their mismatch and the effects for the model. Telemetry that reads no speed as slow as the dead zone may
/// be what rests: then it is none.
void add_rotor_limits(const recording::Recording& recording, const vehicle::Vehicle& vehicle, Diagnosis& d);

}  // namespace omniflight::diagnosis
