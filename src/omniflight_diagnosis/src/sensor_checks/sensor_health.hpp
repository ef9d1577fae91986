// Quality of each sensor from its own samples, without a vehicle model.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// For accelerometer, gyro, pose and estimate: RMS white noise, share of time in gaps and frozen, median
/// specific force, readings at rest, and tracking error where a reference was recorded.
std::vector<SensorFact> sensor_facts(const recording::Recording& recording);

/// Adds stale_samples (a signal that freezes and jumps), gyro_error and accelerometer_error (readings during
/// at least 5 s at rest) with mismatches, and appends gaps and frozen stretches to `windows`.
void add_sensor_health(const recording::Recording& recording, const Options& options, Diagnosis& diagnosis,
                       std::vector<Window>& windows);

}  // namespace omniflight::diagnosis
