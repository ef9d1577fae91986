// Decimation with anti-aliasing by block means.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Averages consecutive blocks of as many samples as fit into `period_s` [s], at their mean times.
/// Quaternions must not change sign within a block. Returns `s` unchanged where fewer than two samples fit.
recording::Signal decimate(const recording::Signal& s, double period_s);

}  // namespace omniflight::diagnosis
