// Proposal of the next flight for an ambiguous posterior.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Fills Diagnosis::next_flight: the pairs of each finding and its rivals, at the parameters of their most
/// probable sets, and manoeuvres ranked by how many pairs they separate. Pairs with physics outside the
/// library come last and have no prediction.
void add_next_flight(const Inference& inference, std::span<const Flight* const> flights,
                     const vehicle::Vehicle& vehicle, const Options& options, Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
