// What a user asks of a diagnosis beside its answer: only these effects, never those, why not that one, what
// was known before.
#pragma once

#include <string>
#include <vector>

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::cli {

struct Questions {
  std::vector<std::string> only, exclude;  ///< effect ids
  std::string why;                         ///< effect id
  std::string prior;                       ///< diagnosis.json of earlier flights of this vehicle
};

/// Into the options of the diagnosis. Errors: bad_input with the nearest effect for an unknown one; what is
/// wrong with the prior's file.
Status ask(const Questions& questions, diagnosis::Options& options);

/// What became of an effect, one line a statement: what was asked of it, with which outcome, and what stands
/// in its place.
std::vector<std::string> why(const std::string& effect, const diagnosis::Diagnosis& d);

}  // namespace omniflight::cli
