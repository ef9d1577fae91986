// Findings on rotor limits that the vehicle file does not contain.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Adds actuator_saturation (a ceiling below the largest speed of the vehicle file) and thrust_dead_zone,
/// with mismatches and effects for the model. A dead zone is a finding only where the telemetry reads slower
/// speeds; otherwise the telemetry itself may read zero.
void add_rotor_limits(const recording::Recording& recording, const vehicle::Vehicle& vehicle, Diagnosis& d);

}  // namespace omniflight::diagnosis
