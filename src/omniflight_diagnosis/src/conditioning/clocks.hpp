// Signals whose clock is far from the others', or runs away from them, are put right.
#pragma once

#include "repair.hpp"

namespace omniflight::diagnosis {

/// Measures lags and skews as recorded, then moves what is off by more than .15 s: the inertial sensor when
/// the pose and the rotors disagree with it alike, else the pose or the rotor speeds. A skew of the pose
/// beyond four standard errors and a millisecond over the recording is taken out.
void settle_clocks(Repaired& recording);

}  // namespace omniflight::diagnosis
