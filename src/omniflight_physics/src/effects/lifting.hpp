// What a cable that is lifted off the floor takes besides its weight.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

/// Downward force [N] of lambda v_z metres and kilograms a second that get the vehicle's speed: a cable of
/// linear density lambda [kg/m] leaves the floor link by link. Laying it down gives nothing back.
template <class T>
T picked_up(const Situation& s, const T& linear_density) {
  const double climb = std::max(0.0, s.body.v_WB_W.z());
  return linear_density * T(climb * climb);
}

}  // namespace omniflight::physics
