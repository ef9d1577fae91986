// Single samples that are not the signal: reflections of a motion capture, bit errors of telemetry.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// The signal with lone outliers replaced by the mean of their neighbours: samples that lie ten times farther
/// than is usual there from everything that their neighbours let expect. A difference taken twice of one of
/// them would stand a thousand times above the noise, and with it the whole spectrum.
recording::Signal without_outliers(const recording::Signal& signal);

}  // namespace omniflight::diagnosis
