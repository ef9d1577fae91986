// Detection and correction of clock offsets and clock drift between signals.
#pragma once

#include "repair.hpp"

namespace omniflight::diagnosis {

/// Measures lags and skews, then corrects the time stamps of the group of signals that lags or leads by more
/// than 0.15 s. Which group it is follows from the pairs that disagree: the onboard estimate when both
/// inertial sensors and measured position contradict it, the inertial sensors when pose and rotors (or
/// estimate) contradict them, else pose or rotor speeds. A drift of the pose clock is corrected where it
/// exceeds four standard errors and 1 ms over the recording. Corrected offsets become findings
/// (clock_offset), drifts become notes.
void settle_clocks(Repaired& recording);

}  // namespace omniflight::diagnosis
