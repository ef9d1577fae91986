// Selection of the signals for a wrench analysis.
#pragma once

#include <optional>

#include "omniflight_core/result.hpp"
#include "repair.hpp"
#include "thrust_source.hpp"

namespace omniflight::diagnosis {

/// Time stamps of the pose are shifted to the clock of the gyro. At least one of acc, position and velocity
/// is set.
struct ChosenSignals {
  recording::Signal attitude;
  ThrustSource rotors;
  const recording::Signal* gyro = nullptr;  ///< owned by the recording, as are acc and velocity
  const recording::Signal* acc = nullptr;
  std::optional<recording::Signal> position;
  const recording::Signal* velocity = nullptr;
  std::vector<Alignment> alignment;  ///< lags between signals, before that shift

  /// All signals that are set.
  std::vector<const recording::Signal*> all() const;
};

/// Measured signals, or the onboard estimate where a measurement is missing or has many gaps; adds notes on
/// that. The result refers to `repaired`. Errors (bad_input): no attitude, no rotor signal, or none of
/// accelerometer, velocity and position.
Result<ChosenSignals> choose_signals(const Repaired& repaired, const vehicle::Vehicle& vehicle,
                                     const Options& options, std::vector<std::string>& notes);

}  // namespace omniflight::diagnosis
