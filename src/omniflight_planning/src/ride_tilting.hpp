// A leg on which the tilt of the rotors moves in flight.
#pragma once

#include "ride_leg.hpp"

namespace omniflight::planning {

/// The fastest ride of a leg, by the minimum-jerk law or, where that is asked for, the shortest timing, that
/// the map, the rotors and the tilt's servo allow: on one curve through the waypoints, rounder or closer to
/// the path, with the tilt in proportion to the way or, where the rotors cannot hold the attitude so, by the
/// least change through tilts at which they can.
Result<Ridden> ride_tilting(const std::vector<Path>& paths, double from, double to,
                            const vehicle::Vehicle& vehicle, Tilts& tilts, const MotionLimits& limits,
                            Timing timing, const Deadline& deadline);

}  // namespace omniflight::planning
