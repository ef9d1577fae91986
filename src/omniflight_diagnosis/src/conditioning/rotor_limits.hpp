// What rotors cannot do, by their commands and their speeds: turn quicker than a ceiling, or slowly.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Of a ceiling: rotors differ by that much.
inline constexpr double kPlateau = 0.01;

/// A speed [rad/s] with what bounds it on both sides.
struct LimitSpeed {
  double value = 0, from = 0, to = 0;
};

struct RotorLimits {
  std::optional<LimitSpeed> ceiling;  ///< speeds that all rotors keep to when they are ordered beyond
  std::optional<LimitSpeed> dead;     ///< commands up to this leave every rotor at rest ...
  bool reads_slower = false;          ///< ... and the telemetry reads such speeds, in passing
  /// A rotor, a sample of the speeds: it stands at one of these limits, as it was ordered beyond.
  std::vector<std::vector<char>> held;
};

/// Judged where a command has lasted for .1 s. A limit must hold for .2 s, and for every rotor: a battery
/// that gives way, a motor that fails or a sensor that is stuck shows none. Empty without rotor_speed and
/// rotor_command of one width.
RotorLimits rotor_limits(const recording::Recording& recording);

/// Where telemetry reads no speed as slow as a rotor is ordered to turn, it says 0: such readings take the
/// command, through the vehicle's lag, in place. Slowest speed that it reads [rad/s]; empty where it reads
/// all.
std::optional<double> fill_slow_readings(const recording::Recording& recording,
                                         const vehicle::Vehicle& vehicle, recording::Signal& speed);

}  // namespace omniflight::diagnosis
