// Plausibility of a recording: units, conventions, match with the vehicle, and whether it flew at all.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Objections to the recording: time stamps, magnitudes, conventions, vehicle; empty when there are none.
/// Each names the signal, what was seen and the likely cause ("'gyro' looks like degrees per second instead
/// of rad/s"). The thresholds are chosen far outside of sound flights: an objection makes the recording
/// unusable. Errors (bad_input): a signal of the wrong width or with values that are not finite, too few
/// samples.
Result<std::vector<std::string>> validate_input(const recording::Recording& recording,
                                                const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
