// Whether what lifts a vehicle close to the floor follows the height law of the ground effect.
#pragma once

#include "naming.hpp"

namespace omniflight::diagnosis {

/// Take-offs and landings show the law for fractions of a second only: too little for the gate of a search
/// over whole flights. Here the passes close to the floor are asked one by one: the strength found on the
/// others must predict half of the slow vertical force of each, taken together, on two passes or more that
/// make up at most 40 % of the flight. The likelihood must rise by more than `per_parameter`, too.
bool follows_ground_law(const Problem& problem, double per_parameter, const Options& options);

/// The naming with the ground effect added, where it raises the likelihood by more than its price and stays
/// within its limits; otherwise unchanged.
void add_ground_law(const Problem& problem, double per_parameter, const Options& options, Naming& naming);

}  // namespace omniflight::diagnosis
