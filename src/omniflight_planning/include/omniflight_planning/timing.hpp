// From a path of poses to a timed curve: twice continuously differentiable, at rest at both ends, within
// limits.
#pragma once

#include <cstddef>
#include <vector>

#include "omniflight_planning/rotors.hpp"
#include "omniflight_planning/state_check.hpp"

namespace omniflight::planning {

/// Limits on the motion of the body origin and of the attitude.
struct MotionLimits {
  double speed = 0.5;                 ///< m/s
  double acceleration = 1.0;          ///< m/s^2
  double rate = to_radians(45);       ///< rad/s
  double angular_acceleration = 3.0;  ///< rad/s^2
  double lean = to_radians(35);       ///< rad of the thrust axis from upright, of underactuated vehicles
  /// Share of every rotor's range, and of the rate of thrust that its lag allows, that stays free, [0, 1).
  double rotor_headroom = 0.1;
};

/// The law of time by which a curve is ridden.
enum class Timing {
  minimum_jerk,  ///< one polynomial for the whole curve: smooth
  shortest,      ///< as fast as limits, rotors and the lag of their motors allow (time_optimal.hpp)
};

/// A curve through poses: natural cubic spline in the chord parameter, of the position and of the rotation
/// vector from the first attitude. Between two poses it is the straight line and the shortest rotation.
class PoseCurve {
 public:
  /// At least two poses; neighbours that coincide are merged.
  explicit PoseCurve(const std::vector<Pose>& poses);

  /// Reference at parameter u with speed du [1/s] and acceleration ddu [1/s^2] along it.
  Reference at(double u, double du, double ddu) const;
  double length() const { return u_.empty() ? 0.0 : u_.back(); }  ///< m, with 0.3 m a radian

 private:
  std::vector<double> u_;
  std::vector<Vec6> value_, curvature_;  // position, rotation vector; and their second derivatives
  Quat q_WF_;                            // attitude that the rotation vectors start from
};

/// Time between knots.
inline constexpr double kKnotPeriod = 0.01;          // s
inline constexpr std::size_t kMaxKnots = 1'000'000;  // as many as a plan file may hold: 2 h 46 min

/// Rides a curve from rest to rest with the minimum-jerk law u = L (10 s^3 - 15 s^4 + 6 s^5), in the shortest
/// time (a whole number of knot periods) that keeps every limit at every knot. Knots start at t = 0.
/// Fails when an attitude on the curve cannot be hovered with the headroom, or the rotors cannot give the
/// motion's direction, which no slowing down can cure, and once the deadline has passed.
Result<std::vector<TrajectoryKnot>> ride(const PoseCurve& curve, const Rotors& rotors,
                                         const MotionLimits& limits, const Deadline& deadline = {});

inline constexpr int kShapeSamples = 400;  // knots at which a duration is judged

/// The parts of ride(): the time [s] that the limits ask for, judged at `samples` places of the curve beside
/// its start, and the first ride that lasts so long at least and keeps the limits at its own knots.
Result<double> least_time(const PoseCurve& curve, const Rotors& rotors, const MotionLimits& limits,
                          const Deadline& deadline = {}, int samples = kShapeSamples);
Result<std::vector<TrajectoryKnot>> ride_from(double least, const PoseCurve& curve, const Rotors& rotors,
                                              const MotionLimits& limits, const Deadline& deadline = {});

/// The largest values on a trajectory, looked at on every knot.
struct MotionPeaks {
  double speed = 0.0, acceleration = 0.0;         ///< m/s, m/s^2
  double rate = 0.0, angular_acceleration = 0.0;  ///< rad/s, rad/s^2
  double lean = 0.0;            ///< rad, of the thrust axis from upright; 0 where the attitude is free
  double rotor_load = 0.0;      ///< share of the rotors' range, 1 is the limit
  double rotor_load_at = 0.0;   ///< s
  ThrustRate thrust_rate;       ///< from a knot to the next, where it needs most
  double thrust_rate_at = 0.0;  ///< s, of the second of them
};
MotionPeaks peaks(const std::vector<TrajectoryKnot>& knots, const Rotors& rotors);
/// Of two motions, the second of which begins at `start` [s] in its own time.
MotionPeaks larger(const MotionPeaks& a, MotionPeaks b, double start);

}  // namespace omniflight::planning
