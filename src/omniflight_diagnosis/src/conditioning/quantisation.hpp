// Rotor speeds that keep to steps where their commands do not.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Step [rad/s] to whose multiples the measured speeds keep while the commands run through all values: the
/// largest for which the phases 2 pi speed/step gather and those of the commands spread. Nothing without both
/// signals, or where speeds stay within a few steps.
std::optional<double> speed_step(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
