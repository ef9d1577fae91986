// A fast signal at a slow rate.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Means over as many samples as fit into `period_s` [s], at their mean times, so that noise beyond the slow
/// rate does not fold back. Of attitudes whose sign does not jump. Unchanged where fewer than two fit.
recording::Signal decimate(const recording::Signal& s, double period_s);

}  // namespace omniflight::diagnosis
