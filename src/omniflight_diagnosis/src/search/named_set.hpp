// From the posterior to what is said: the set of effects that the answer names.
#pragma once

#include "inference.hpp"

namespace omniflight::diagnosis {

/// The members of the likeliest candidate that the answer names, fitted without the others, the likeliest
/// first: one where there is an alarm, and those that are likelier there than not (kBeside) and for
/// which the flight speaks. None that does less than arithmetic leaves.
SetFit named_set(const Inference& inference, const Options& options);

/// Root mean square distance of parameter k of this hypothesis from `value` in the posterior: over all sets
/// with the hypothesis, each with its own estimate and standard deviation. 0 where no set has it.
double deviation_over_sets(const Posterior& posterior, const std::vector<Hypothesis>& hypotheses,
                           int hypothesis, std::size_t k, double value);

}  // namespace omniflight::diagnosis
