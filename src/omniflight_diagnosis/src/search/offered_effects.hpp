// Which effects of the library these flights can show at all.
#pragma once

#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// Why these flights, or the caller, do not let an effect of the wrench be asked for; empty where it is
/// asked.
std::string why_not_offered(const physics::Effect& effect, std::span<const Flight* const> flights,
                            const vehicle::Vehicle& vehicle, const Options& options);

/// Wrench effects of the library for which these flights have the signals.
std::vector<const physics::Effect*> offered_effects(std::span<const Flight* const> flights,
                                                    const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
