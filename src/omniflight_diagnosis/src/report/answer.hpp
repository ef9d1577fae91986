// Answer from the posterior: verdict, findings with credible sets, remaining residual, decisions.
#pragma once

#include "../search/named_set.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Adds to d what the posterior and the `named` set (named_set()) give for the wrench: mismatch, findings,
/// unexplained, model, in-sample fit, series, decisions, candidates, remaining, and the verdict.
void add_posterior(const Inference& inference, const SetFit& named, std::span<const Flight* const> flights,
                   Diagnosis& d);

}  // namespace omniflight::diagnosis
