// The next flight after a posterior that leaves names open.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// For every finding and what it cannot be told apart from: the pair, at the values that each has in its
/// likeliest set, and the manoeuvres that would separate most of these pairs. Fills Diagnosis::next_flight;
/// pairs with physics outside the library come last and without a prediction.
void add_next_flight(const Inference& inference, std::span<const Flight* const> flights,
                     const vehicle::Vehicle& vehicle, const Options& options, Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
