// Excitation and detectability of effects in a flight, before anything is fitted.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// Sets in `intake`: ranges of the state variables; for every candidate the norm, in standard deviations of
/// the noise (temperature included), of its contribution at typical parameters that calibration cannot
/// imitate; and groups of candidates whose contributions lie within 11 deg (cosine 0.98) of each other's
/// tangent space.
void describe_candidates(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                         const std::vector<const physics::Effect*>& candidates, const Options& options,
                         Intake& intake);

}  // namespace omniflight::diagnosis
