// Rotor speeds from whatever tells them: a sensor, a command, or a duty cycle with the battery voltage.
#pragma once

#include <optional>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Where the rotor speeds of an analysis come from, best first.
enum class SpeedSource { measured, commanded, modelled };

struct ThrustSource {
  SpeedSource kind = SpeedSource::measured;
  recording::Signal speed;  ///< rad/s a rotor; a modelled one carries an unknown common scale
  std::string note;         ///< what this costs, in a sentence; empty for measured speeds
};

/// Thrust goes with the square of speed, and speed with duty cycle times voltage to this power (measured on
/// brushed and brushless motors: 0.8 to 0.9).
inline constexpr double kDutyToSpeed = 0.85;

/// Empty when the recording has none of rotor_speed, rotor_command, thrust_model, pwm, motor_power.
std::optional<ThrustSource> thrust_source(const recording::Recording& recording,
                                          const vehicle::Vehicle& vehicle);

}  // namespace omniflight::diagnosis
