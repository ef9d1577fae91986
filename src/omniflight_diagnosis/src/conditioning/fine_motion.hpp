// What a recording tells of the motion and of the rotors, on the fine grid.
#pragma once

#include "grid.hpp"
#include "signal_choice.hpp"

namespace omniflight::diagnosis {

/// One row a sample of the grid.
struct FineMotion {
  Eigen::MatrixXd attitude;                    ///< (w, x, y, z), world <- body
  Eigen::MatrixXd position, velocity;          ///< m, m/s, world; zero where nothing tells them
  Eigen::MatrixXd rate, angular_acceleration;  ///< rad/s, rad/s^2, body
  Eigen::MatrixXd specific_force;              ///< m/s^2, body
  Eigen::MatrixXd rotor_speed;                 ///< rad/s: what thrust follows, root of filtered squares
  Eigen::MatrixXd rotor_turning;               ///< rad/s: what momentum follows, filtered as it is
  Eigen::MatrixXd alpha;                       ///< rad, one column; zero where it was not recorded
};

/// The time that all chosen signals share. Errors: less than 2 s, or more than two hours.
Result<Grid> fine_grid(const ChosenSignals& signals, const std::string& file, const Options& options);

/// Takes out of `used` where a signal has a gap, except where `repaired` has cut it already. Sets what the
/// flight has (gyroscope, accelerometer, position, tilt angle), its kernel and its alignment, and adds to its
/// notes what a missing signal costs.
FineMotion fine_motion(const ChosenSignals& signals, const Repaired& repaired, const Grid& grid,
                       const vehicle::Vehicle& vehicle, const Options& options, UsedSamples& used, Flight& f);

/// See Flight::reference.
Eigen::MatrixXd reference_motion(const recording::Recording& recording, const Grid& grid,
                                 const Options& options);

}  // namespace omniflight::diagnosis
