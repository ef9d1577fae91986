// Detection of quantised rotor speeds.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Quantisation step [rad/s] of the measured speeds: the largest for which the phases 2 pi speed / step are
/// concentrated while those of the commands are spread. Empty without quantisation, without both signals, or
/// with fewer than 500 steady samples.
std::optional<double> speed_step(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
