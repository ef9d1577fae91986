// Manoeuvres worth flying to tell explanations apart.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Flights of half a minute to three minutes about one place with rotors tilted by `alpha` [rad], or by an
/// angle near it. Start and predicted separation are left open.
std::vector<ProposedFlight> manoeuvres(const vehicle::Vehicle& vehicle, double alpha);

}  // namespace omniflight::diagnosis
