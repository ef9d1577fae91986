// Findings of the stages beside the wrench, judged as the wrench is: by a Bayes factor and prior odds.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Those flights whose rotor speeds can be believed.
std::vector<const Flight*> with_honest_speeds(const std::vector<Flight>& flights);

/// Posterior probability that a parameter with this estimate and standard error is not its neutral value:
/// normal likelihood, prior N(neutral, deviation^2) against a point at neutral, with these log prior odds.
double presence(double estimate, double standard_error, double deviation, double log_odds);

/// Adds to d those findings of `others` that are likelier there than not, with that probability, and what
/// belongs to them.
void add_judged(const Diagnosis& others, const vehicle::Vehicle& vehicle, const Options& options,
                Diagnosis& d);

}  // namespace omniflight::diagnosis
