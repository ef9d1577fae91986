// From the posterior to the answer: verdict, findings with their credible sets, what remains, decisions.
#pragma once

#include "../search/named_set.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Writes what the posterior, and the set that is named, say of the wrench into d: mismatch, findings,
/// unexplained, model, fit in sample, series, decisions, remaining, and the verdict.
void add_posterior(const Inference& inference, const SetFit& named, std::span<const Flight* const> flights,
                   Diagnosis& d);

}  // namespace omniflight::diagnosis
