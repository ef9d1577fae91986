// From the posterior to the answer: verdict, findings with their credible sets, what remains, decisions.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Writes what the posterior says of the wrench into d: mismatch, findings, unexplained, model, fit in
/// sample, series, decisions, remaining, and the verdict.
void add_posterior(const Inference& inference, std::span<const Flight* const> flights, const Options& options,
                   Diagnosis& d);

}  // namespace omniflight::diagnosis
