// How likely an effect of sensors, drives or control is before a flight.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// ln of the prior odds that a recording has this effect, which acts beside the wrench.
double log_odds_beside_wrench(const physics::EffectInfo& info);

}  // namespace omniflight::diagnosis
