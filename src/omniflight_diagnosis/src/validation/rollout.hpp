// Open-loop prediction error over time.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// RMS errors of position [m] and attitude [deg] of open-loop rollouts after 0.1, 0.5 and 2 s, without and
/// with the effects. Rollouts start every 0.5 s or more (about 200 per flight at most). Empty where a flight
/// has no position.
std::vector<RolloutFit> rollouts(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                                 const std::vector<physics::ActiveEffect>& effects, const Options& options);

}  // namespace omniflight::diagnosis
