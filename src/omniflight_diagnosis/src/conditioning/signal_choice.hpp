// Which signals of a recording an analysis of the wrench takes.
#pragma once

#include <optional>

#include "omniflight_core/result.hpp"
#include "repair.hpp"
#include "thrust_source.hpp"

namespace omniflight::diagnosis {

/// The pose is on the clock of the gyroscope. At least one of the last three is there.
struct ChosenSignals {
  recording::Signal attitude;
  ThrustSource rotors;
  const recording::Signal* gyro = nullptr;  ///< of the recording, as the next
  const recording::Signal* acc = nullptr;
  std::optional<recording::Signal> position;
  const recording::Signal* velocity = nullptr;
  std::vector<Alignment> alignment;  ///< between the clocks of signals

  /// All that are there.
  std::vector<const recording::Signal*> all() const;
};

/// Adds to `notes` what a missing signal costs. Errors: no attitude, nothing that tells of the rotors, none
/// of accelerometer, velocity and position.
Result<ChosenSignals> choose_signals(const Repaired& repaired, const vehicle::Vehicle& vehicle,
                                     const Options& options, std::vector<std::string>& notes);

}  // namespace omniflight::diagnosis
