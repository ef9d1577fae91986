// Speed limits of the rotors from commands and speeds: a ceiling, and a dead zone of the command.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Relative spread of the speeds of different rotors at one ceiling. Chosen.
inline constexpr double kPlateau = 0.01;

/// A speed [rad/s] with its bounds.
struct LimitSpeed {
  double value = 0, from = 0, to = 0;
};

struct RotorLimits {
  std::optional<LimitSpeed> ceiling;  ///< common largest speed under larger commands
  std::optional<LimitSpeed> dead;     ///< commands up to this leave every rotor at rest
  bool reads_slower = false;          ///< the telemetry resolves speeds below the dead zone
  /// Per rotor and speed sample: whether the rotor is at one of these limits.
  std::vector<std::vector<char>> held;
};

/// Evaluates states that have lasted for 0.1 s. A limit must hold for 0.2 s in total and for all rotors,
/// which distinguishes it from a sagging battery, a failing motor or a stuck sensor. Empty without
/// rotor_speed and rotor_command of equal width.
RotorLimits rotor_limits(const recording::Recording& recording);

/// Telemetry that times revolutions reads 0 below a least speed. Replaces such zeros in `speed` by the
/// command through the nominal lag. Returns the least speed [rad/s] that is read; empty where nothing was
/// replaced.
std::optional<double> fill_slow_readings(const recording::Recording& recording,
                                         const vehicle::Vehicle& vehicle, recording::Signal& speed);

}  // namespace omniflight::diagnosis
