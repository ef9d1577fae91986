// What a diagnosis means for the vehicle, in words a pilot uses.
#pragma once

#include <string>

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::cli {

/// "0.28 kg too heavy". Sizes that the flight does not identify are left out; without words of its own an
/// effect is its term and its largest number.
std::string pilot_words(const diagnosis::Finding& finding);

/// The first sentence of a report: what is wrong with the vehicle, then with its control and sensors, and
/// what cannot be told apart. Of an answer without a model (checked, unfinished, unusable): that.
std::string first_sentence(const diagnosis::Diagnosis& diagnosis);

/// Whether left-out physics of the vehicle is among the findings; control and sensors are none.
bool names_physics(const diagnosis::Diagnosis& diagnosis);

}  // namespace omniflight::cli
