// Gains for a vehicle that leans to accelerate, as stiff as its motors allow.
#pragma once

#include "omniflight_control/controller.hpp"

namespace omniflight::control {

/// Share of a loop's bandwidth times the motors' time constant that leaves a phase margin.
inline constexpr double kLagShare = 0.6;

/// The attitude loop (12.25 rad/s at most) stays below what the motors' lag [s] allows, and is the position's
/// actuator: its bandwidth is four times that of the position loop, and six where no feed-forward leads it
/// (the cascaded law).
ControllerConfig leaning_gains(double motor_time_constant, bool led = true);

}  // namespace omniflight::control
