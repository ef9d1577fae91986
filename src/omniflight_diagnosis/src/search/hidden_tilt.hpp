// A tilt that lags behind what its servo reports: nothing in the reports shows it, only the wrench does.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// tilt_servo_lag as a law of the wrench, with its time constant [s] alone: the rotors stand at
/// alpha_s, d alpha_s/dt = (alpha - alpha_s)/tau, while alpha is reported [rad].
const physics::Effect& hidden_tilt_lag();

}  // namespace omniflight::diagnosis
