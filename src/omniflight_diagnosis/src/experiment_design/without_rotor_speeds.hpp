// Detectability for a recording without rotor signals, if rotor speeds had been recorded.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Adds excitation, detectability and alias groups as check() does, with the speeds that the nominal vehicle
/// needs for the recorded motion. This is an upper bound, since no disturbance is included. Adds nothing
/// without attitude or with too little flight.
void add_detectability_with_rotor_speeds(const recording::Recording& recording,
                                         const vehicle::Vehicle& vehicle, const Options& options,
                                         Intake& intake);

/// The same as sentences; empty when nothing was added. Effects count as visible from 3 sigma on.
std::string detectability_in_words(const Intake& intake);

}  // namespace omniflight::diagnosis
