// Open-loop flight from recorded rotor speeds: how fast do model and recording part?
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Root mean square of the final position [m] and attitude [deg] errors of rollouts started every half
/// second, at 0.1, 0.5 and 2 s, without and with the effects. Needs positions.
std::vector<RolloutFit> rollouts(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                                 const std::vector<physics::ActiveEffect>& effects, const Options& options);

}  // namespace omniflight::diagnosis
