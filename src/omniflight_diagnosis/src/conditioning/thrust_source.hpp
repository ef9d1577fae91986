// Rotor speeds from the best available signal: measurement, command, or duty cycle with battery voltage.
#pragma once

#include <optional>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Origin of the rotor speeds, best first.
enum class SpeedSource { measured, commanded, modelled };

struct ThrustSource {
  SpeedSource kind = SpeedSource::measured;
  recording::Signal speed;  ///< rad/s, samples x rotors; a modelled one has an unknown common scale
  std::string note;         ///< consequence for the analysis; empty for measured speeds
};

/// Exponent of rotor speed over duty cycle times voltage. Chosen: the middle of 0.8 to 0.9, the range seen on
/// brushed and brushless motors (no published source); Tolerance::modelled_exponent covers the deviation.
inline constexpr double kDutyToSpeed = 0.85;

/// From the first of rotor_speed, rotor_command, thrust_model, pwm, motor_power with one column per rotor;
/// empty without.
std::optional<ThrustSource> thrust_source(const recording::Recording& recording,
                                          const vehicle::Vehicle& vehicle);

}  // namespace omniflight::diagnosis
