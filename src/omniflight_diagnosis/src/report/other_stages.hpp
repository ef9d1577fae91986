// Findings of the stages beside the wrench, judged as the wrench is: by a Bayes factor and prior odds.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Those flights whose rotor speeds can be believed.
std::vector<const Flight*> with_honest_speeds(const std::vector<Flight>& flights);

/// Gives every finding of such a stage its posterior probability: by the parameter that is farthest from its
/// neutral value for its prior, or by Finding::log_factor where it has none; shared equally with the rivals
/// that explain the recording as well.
void judge_sizes(const vehicle::Vehicle& vehicle, const Options& options, std::vector<Finding>& findings);

/// Adds to d those findings of `others` that are likelier there than not, with that probability, and what
/// belongs to them.
void add_judged(const Diagnosis& others, const vehicle::Vehicle& vehicle, const Options& options,
                Diagnosis& d);

}  // namespace omniflight::diagnosis
