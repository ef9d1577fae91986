// Rotor commands, headroom and clearance of every knot of a finished plan.
#pragma once

#include "omniflight_planning/plan.hpp"
#include "tilts.hpp"

namespace omniflight::planning {

/// Of the knots in turn until the deadline passes, so that there may be fewer than knots. Thrusts are those
/// of the least sum of squares within the rotors' limits that give the motion's wrench, for `vehicle` with
/// all that it carries; flights may share them out differently.
Result<std::vector<KnotFigures>> figures_of(const std::vector<TrajectoryKnot>& knots,
                                            const vehicle::Vehicle& vehicle, Tilts& tilts,
                                            const Deadline& deadline);

}  // namespace omniflight::planning
