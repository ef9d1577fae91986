// Removal of isolated outliers: reflections in motion capture, bit errors of telemetry.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// The signal with isolated outliers replaced by the mean of both neighbours. A sample is an outlier where
/// its distance from interpolation and extrapolation by its neighbours exceeds ten times the local mean of
/// that distance, per component. One outlier, differentiated twice, would dominate the noise spectrum of the
/// whole flight.
recording::Signal without_outliers(const recording::Signal& signal);

}  // namespace omniflight::diagnosis
