// What a motion could show if its rotors had been recorded as well.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Excitation, detectability and alias groups as check() gives them, with the speeds that the nominal vehicle
/// would need for this motion in place of those nobody recorded. A bound from above: nothing disturbed that
/// vehicle. Without an attitude, or without enough flight, nothing is added.
void add_detectability_with_rotor_speeds(const recording::Recording& recording,
                                         const vehicle::Vehicle& vehicle, const Options& options,
                                         Intake& intake);

/// In a sentence or two; empty when nothing was added.
std::string detectability_in_words(const Intake& intake);

}  // namespace omniflight::diagnosis
