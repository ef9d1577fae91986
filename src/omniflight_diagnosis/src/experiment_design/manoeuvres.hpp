// Catalogue of manoeuvres for the next flight.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Flights of half a minute to three minutes around one point, with rotor tilt `alpha` [rad] or near it; only
/// those that the actuation allows. Start and predicted separations are not set.
std::vector<ProposedFlight> manoeuvres(const vehicle::Vehicle& vehicle, double alpha);

}  // namespace omniflight::diagnosis
