// From the posterior to the answer: verdict, findings with their credible sets, what remains, decisions.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Members of the best set (indices) that the answer names; none without an alarm.
std::vector<std::size_t> named_members(const Inference& inference);

/// Writes what the posterior says of the wrench into d: mismatch, findings, unexplained, model, fit in
/// sample, series, decisions, remaining, and the verdict.
void add_posterior(const Inference& inference, std::span<const Flight* const> flights, Diagnosis& d);

}  // namespace omniflight::diagnosis
