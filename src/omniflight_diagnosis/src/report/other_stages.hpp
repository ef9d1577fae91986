// Posterior probabilities of findings of the stages other than the wrench, by Bayes factors and prior odds.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Flights without a rotor speed sensor fault.
std::vector<const Flight*> with_honest_speeds(const std::vector<Flight>& flights);

/// Sets Finding::probability from prior odds (log_odds_beside_wrench()) and the Bayes factor:
/// Finding::log_factor where given, else the largest Bayes factor among its parameters (estimate and interval
/// against the prior of that parameter). The probability is divided equally among the finding and its rivals.
/// NaN for an id outside the library.
void judge_sizes(const vehicle::Vehicle& vehicle, const Options& options, std::vector<Finding>& findings);

/// Adds to d the findings of `others` whose probability, rivals included, is at least 0.5, with model
/// effects, mismatches and decisions. Raises the verdict nothing_missing to explained if any was added.
void add_judged(const Diagnosis& others, const vehicle::Vehicle& vehicle, const Options& options,
                Diagnosis& d);

}  // namespace omniflight::diagnosis
