// Whether a curve is free while the tilt of the rotors moves along it.
#pragma once

#include "tilt.hpp"
#include "tilts.hpp"

namespace omniflight::planning {

/// Upper bound [m/s] of the speed at which the points of the tilting rotor discs move in the body, between
/// two knots.
double rim_speed(const vehicle::Vehicle& vehicle, const TrajectoryKnot& k0, const TrajectoryKnot& k1);

/// StateCheck::curve for a piece of a trajectory on which the tilt moves. Each pose is looked at with the
/// nearest of tilts a degree apart, less what the rims travel from there.
Result<CurveCheck> curve_while_tilting(const Trajectory& trajectory, const TiltPiece& piece,
                                       const vehicle::Vehicle& vehicle, Tilts& tilts,
                                       const Deadline& deadline);

}  // namespace omniflight::planning
