// A pose that nothing but itself tells the acceleration of, in two halves with noise of their own.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Every second sample each. Inertia times twice differentiated noise is what a spring to that noise looks
/// like: with one pose on both sides of the regression a quiet flight without IMU has a spring.
struct Halves {
  recording::Signal seen;            ///< by the effects
  recording::Signal differentiated;  ///< into rate and acceleration
};

/// Samples that repeat the one before are left out. Nothing where half of the rest would be too slow for
/// cutoff_hz.
std::optional<Halves> halves_of(const recording::Signal& pose, double cutoff_hz);

}  // namespace omniflight::diagnosis
