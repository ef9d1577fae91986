// Lines of the rotors in the accelerometer: imbalance.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Adds `vibration` where the accelerometer has a line at the phase of a rotor, the integral of its speed,
/// that the frequencies beside it do not have. Judged only where the noise of the accelerometer is told:
/// every rotor shakes a little, and only that number says what the reading has beside the force. Without
/// rotor speeds, those that the commands reach through the nominal lag are taken.
void add_vibration(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                   const Options& options, Diagnosis& d);

}  // namespace omniflight::diagnosis
