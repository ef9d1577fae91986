// Rotor commands, headroom and clearance of every knot of a finished plan.
#pragma once

#include "omniflight_planning/plan.hpp"
#include "tilts.hpp"

namespace omniflight::planning {

/// Of the knots in turn until the deadline passes, so that there may be fewer than knots. Thrusts are those
/// of Rotors, for the vehicle of `tilts` with all that it carries.
Result<std::vector<KnotFigures>> figures_of(const std::vector<TrajectoryKnot>& knots, Tilts& tilts,
                                            const Deadline& deadline);

/// Energy [J] that the rotors' drag takes on the way, by every few knots: speed times reaction torque. Of a
/// motion that is cut short by the deadline, nothing.
Result<std::optional<double>> energy_of(const std::vector<TrajectoryKnot>& knots, Tilts& tilts,
                                        const vehicle::Vehicle& vehicle, const Deadline& deadline);

}  // namespace omniflight::planning
