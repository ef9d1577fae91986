// How fast a curve can be ridden at most within the rotors' range and the limits of the motion, and rides
// that come near to it within the lag of the motors.
#pragma once

#include "omniflight_planning/timing.hpp"

namespace omniflight::planning {

/// Speed along a curve from rest to rest, the acceleration constant between equal steps of its parameter.
class SpeedProfile {
 public:
  /// length: m, of the curve; squares: m^2/s^2, of the speed at the places, 0 at both ends and nowhere else.
  SpeedProfile(double length, const std::vector<double>& squares);

  double duration() const { return t_.back(); }  ///< s

  struct Law {
    double u, du, ddu;  ///< m, m/s, m/s^2
  };
  /// Moving average over `width` [s] of the ride, which rests before and after it: from rest at t = 0 to rest
  /// at t = duration() + width. The acceleration is continuous and changes by less than 2 max |ddu| / width.
  Law averaged(double t, double width) const;

 private:
  struct Moment {
    double sum, u, du;  // m s, integral of u since the start; m; m/s
  };
  Moment at(double t) const;

  std::vector<double> t_, u_, du_, sum_;  // at the places
};

/// The fastest profile (time-optimal path parameterisation: Bobrow, Dubowsky and Gibson 1985; backward and
/// forward pass as Pham and Pham 2018) whose rotor load and motion keep the limits at every place. The
/// acceleration jumps, so that no rotor with a lag can do it: its duration is a lower bound, up to the
/// places' number. Fails as ride() does, and for a rank below 6 of the allocation matrix.
Result<SpeedProfile> time_optimal(const PoseCurve& curve, const allocation::RotorLoad& rotors,
                                  const MotionLimits& limits, int steps = 200, const Deadline& deadline = {});

/// Rides a curve by the average of its fastest profile over the shortest width that the lag of the motors
/// allows, all of it slowed down until every limit is kept at every knot; by the minimum-jerk law where that
/// is shorter. Knots, ends and failures as of ride().
Result<std::vector<TrajectoryKnot>> ride_shortest(const PoseCurve& curve, const Rotors& rotors,
                                                  const MotionLimits& limits, const Deadline& deadline = {});

}  // namespace omniflight::planning
