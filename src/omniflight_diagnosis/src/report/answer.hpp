// From the posterior to the answer: verdict, findings with their credible sets, what remains, decisions.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Members of the best set (indices) that the answer names: as many as there are at least in all but kAlarm
/// of the posterior (an alarm is the first of them), the likeliest first. What stands for one of them
/// elsewhere counts for it. None without an alarm, and none that does less than arithmetic leaves.
std::vector<std::size_t> named_members(const Inference& inference);

/// Writes what the posterior says of the wrench into d: mismatch, findings, unexplained, model, fit in
/// sample, series, decisions, remaining, and the verdict.
void add_posterior(const Inference& inference, std::span<const Flight* const> flights, Diagnosis& d);

}  // namespace omniflight::diagnosis
