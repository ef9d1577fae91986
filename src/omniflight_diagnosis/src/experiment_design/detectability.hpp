// Which effects a flight could show, and which look alike in it, before anything is fitted.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// What the flights excite, how well every candidate could be seen at an ordinary size beside the calibration
/// (in standard deviations of the noise that the search takes, temperature included), and which look alike:
/// whitened columns with cosines above 0.98 both ways.
void describe_candidates(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                         const std::vector<const physics::Effect*>& candidates, const Options& options,
                         Intake& intake);

}  // namespace omniflight::diagnosis
