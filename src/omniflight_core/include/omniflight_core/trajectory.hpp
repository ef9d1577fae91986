// A timed 6D trajectory: knots with two derivatives, quintic Hermite in between, so that position and
// attitude are twice continuously differentiable.
#pragma once

#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight {

struct TrajectoryKnot {
  double t = 0.0;       ///< s since the start of the trajectory
  Reference reference;  ///< what is asked at t
};

/// Immutable after construction; sampling allocates nothing and is safe from several threads.
class Trajectory {
 public:
  Trajectory() = default;

  /// Knots must be finite, strictly increasing in time, start at t = 0 and be less than pi apart in attitude;
  /// ErrorCode::bad_input names the knot.
  static Result<Trajectory> create(std::vector<TrajectoryKnot> knots);

  /// Reference at t [s]; before the start and after the end it holds the end pose at rest.
  Reference sample(double t) const;

  double duration() const { return knots_.empty() ? 0.0 : knots_.back().t; }  ///< s
  bool empty() const { return knots_.empty(); }
  const std::vector<TrajectoryKnot>& knots() const { return knots_; }

 private:
  /// Rotation-vector polynomial of one interval, relative to the attitude of its first knot.
  struct Interval {
    Eigen::Matrix<double, 3, 6> position;  ///< quintic coefficients in (t - t_k)
    Eigen::Matrix<double, 3, 6> rotation;
    double alpha0 = 0.0, alpha_rate = 0.0;
  };
  std::vector<TrajectoryKnot> knots_;
  std::vector<Interval> intervals_;
};

}  // namespace omniflight
