// The part of a diagnosis that is known before anything is fitted.
#pragma once

#include "naming.hpp"

namespace omniflight::diagnosis {

/// Signals, clocks, excitation and notes of one flight.
Intake describe(const recording::Recording& recording, const Flight& flight);

/// How well every candidate could be seen at an ordinary size, and which look alike: whitened columns with
/// cosines above 0.98 both ways.
void describe_candidates(const Problem& problem, const std::vector<const physics::Effect*>& candidates,
                         Intake& intake);

}  // namespace omniflight::diagnosis
