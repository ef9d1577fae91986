// A leg of a mission, from stop to stop, as a timed curve.
#pragma once

#include "tilts.hpp"

namespace omniflight::planning {

using Path = std::vector<Pose>;
using Knots = std::vector<TrajectoryKnot>;

struct Ridden {
  Knots knots;
  bool stops_on_the_way = false;
};

/// Appends knots that begin where `all` ends.
void append(Knots& all, const Knots& more);

/// The fastest ride of a leg (one path between each two of its waypoints) that the map and the rotors allow:
/// on one curve through the waypoints, rounder or closer to the path, or with a stop at every corner, where
/// the curve is the path. A vehicle that leans into its motion and finds no room for it is slowed down, which
/// makes it lean less; `timing` is for the others.
Result<Ridden> ride_leg(const std::vector<Path>& paths, const AtTilt& tilt, const MotionLimits& limits,
                        Timing timing, const Deadline& deadline);

}  // namespace omniflight::planning
