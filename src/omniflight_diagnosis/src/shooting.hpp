// Multiple-shooting output error: values of named effects for which short open-loop flights, each from a free
// initial state, stay closest to the recorded motion. A regression on a measured state sees the noise of that
// state on both sides of the equation; this sees it on one.
#pragma once

#include <optional>

#include "fit.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

struct Refined {
  Fit fit;  ///< the model with refined values; offsets and noise as they were
  Shooting summary;
};

/// Refines amplitudes and shapes within the bounds that make sense, on two windows of half a second in three;
/// nothing unless the third ones, flown from the measured state, end closer to what was measured by two
/// standard errors, and unless the forces and torques themselves are explained as well as before, within two
/// nats: an attitude that is measured askew leans gravity into every window, and a drag would
/// bend to answer for it. Needs positions and measured rotor speeds, and no effect with memory. Ceres,
/// single-threaded: the same result run to run.
std::optional<Refined> refine_by_shooting(std::span<const Flight* const> flights,
                                          const vehicle::Vehicle& vehicle, const Problem& problem,
                                          const Fit& model, const Options& options);

}  // namespace omniflight::diagnosis
