// Whether a recording can be believed at all: units, conventions, the vehicle, and whether it ever flew.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Sentences that speak against the recording, most telling first; empty when nothing does. Each names the
/// signal, what was seen and what it looks like ("gyro looks like degrees per second").
/// Errors: a signal of the wrong width, or too few samples to look at (bad_input).
Result<std::vector<std::string>> validate_input(const recording::Recording& recording,
                                                const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
