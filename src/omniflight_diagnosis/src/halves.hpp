// A signal that stands on both sides of the regression, in two halves with noise of their own.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Every second sample each. A pose that nothing but itself tells the acceleration of: inertia times twice
/// differentiated noise is what a spring to that noise looks like, and a quiet flight without IMU has a
/// spring. Rotor speeds: less thrust for the same speed takes their noise out of the residual, and a quiet
/// flight has rotors that are too weak.
struct Halves {
  recording::Signal seen;        ///< by the effects
  recording::Signal subtracted;  ///< what makes the residual: rate, acceleration, nominal thrust
};

/// A pose that repeats the sample before is an old one; a rotor may well keep its speed.
enum class Repeats { left_out, kept };

/// Nothing where half of the samples would be too slow for cutoff_hz.
std::optional<Halves> halves_of(const recording::Signal& signal, double cutoff_hz,
                                Repeats repeats = Repeats::left_out);

}  // namespace omniflight::diagnosis
