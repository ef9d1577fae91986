// What a sensor's own samples say of it, without any model of the vehicle.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Of accelerometer, gyro and pose: noise (white, from third differences), share of time lost in gaps or
/// frozen, magnitude of gravity, what is read while nothing moves, and, against a reference, the tracking.
std::vector<SensorFact> sensor_facts(const recording::Recording& recording);

/// Findings stale_samples (a signal that freezes and then jumps), gyro_error and accelerometer_error (what is
/// read through five still seconds or more), each with its mismatch; gaps and frozen stretches as windows.
void add_sensor_health(const recording::Recording& recording, const Options& options, Diagnosis& diagnosis,
                       std::vector<Window>& windows);

}  // namespace omniflight::diagnosis
