// Prior odds of effects of sensors, drives and control.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// ln prior odds that a recording has this effect, which belongs to another stage than the wrench: an
/// expected number of such effects, divided among them by physics::occurrence().
double log_odds_beside_wrench(const physics::EffectInfo& info);

}  // namespace omniflight::diagnosis
