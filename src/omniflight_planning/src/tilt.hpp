// Moving the tilt of the rotors, as fast as half of what the servo can: at rest in one place, or in flight.
#pragma once

#include "omniflight_planning/timing.hpp"

namespace omniflight::planning {

/// Knots [first, last] of a trajectory during which the tilt rests, or moves. Neighbours share a knot.
struct TiltPiece {
  std::size_t first = 0, last = 0;
  bool moves = false;
};
std::vector<TiltPiece> tilt_pieces(const std::vector<TrajectoryKnot>& knots);

/// Knots of a move from one tilt to another [rad] with smooth ends, the vehicle resting at `pose`; rate:
/// rad/s, that the servo can do. The first knot is at t = 0.
std::vector<TrajectoryKnot> move_tilt(const Pose& pose, double from, double to, double rate);

/// Share of the servo's rate that plans use, so that it can follow.
inline constexpr double kShareOfRate = 0.5;
/// The fastest motion of the tilt [rad/s] from a knot to the next.
double fastest_tilt(const std::vector<TrajectoryKnot>& knots);

/// How far [m] no point of a rotor disc moves beyond when every tilting rotor turns by `angle` [rad].
double rim_travel(const vehicle::Vehicle& vehicle, double angle);

/// What a piece whose tilt moves asks of the rotors and of the motion, every knot at its own tilt; headroom
/// as Rotors::create takes it.
Result<MotionPeaks> peaks_while_tilting(const vehicle::Vehicle& vehicle,
                                        const std::vector<TrajectoryKnot>& knots, const TiltPiece& piece,
                                        double headroom, const Deadline& deadline = {});

/// Largest share of the rotors' range that a whole flight of a vehicle needs, every piece at its own tilt.
Result<double> load_alone(const vehicle::Vehicle& vehicle, const std::vector<TrajectoryKnot>& knots);

}  // namespace omniflight::planning
