// The shortest timing of a leg on which the tilt of the rotors moves.
#pragma once

#include "ride_leg.hpp"
#include "tilt_way.hpp"

namespace omniflight::planning {

/// As ride_shortest(), with the rotors of each place at its tilt, and the tilt no faster than the share of
/// the servo's rate that plans use. `best`: a ride of the same curve and way, which is returned where none is
/// shorter or the deadline has passed.
Knots ride_shortest_tilting(const PoseCurve& curve, const TiltWay& way, const vehicle::Vehicle& vehicle,
                            const MotionLimits& limits, Knots best, const Deadline& deadline);

}  // namespace omniflight::planning
