// Recordings without a wrench analysis: their sensors, and what to record next time.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Sensor findings and intake of one recording, without a rotor model: clocks, noise, gaps, freezes, readings
/// at rest, consistency of accelerometer and pose, and inverse dynamics. The verdict is not set.
Diagnosis judge_sensors_of(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                           const Options& options);

/// The answer (verdict unusable) for such recordings; `why`: the reason, for the summary.
Diagnosis diagnose_sensors(std::span<const recording::Recording> flown, const vehicle::Vehicle& vehicle,
                           const Options& options, const std::string& why);

/// Why these signals do not allow a wrench analysis; empty if they do.
std::string missing_reason(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
