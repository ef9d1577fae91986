// Which effects of the library these flights can show at all.
#pragma once

#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// Wrench effects of the library for which these flights have the signals.
std::vector<const physics::Effect*> offered_effects(std::span<const Flight* const> flights,
                                                    const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
