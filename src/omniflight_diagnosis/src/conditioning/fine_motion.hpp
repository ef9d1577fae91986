// Motion and rotor states of a recording, resampled onto the fine grid.
#pragma once

#include "grid.hpp"
#include "signal_choice.hpp"

namespace omniflight::diagnosis {

/// One row per grid sample.
struct FineMotion {
  Eigen::MatrixXd attitude;                    ///< (w, x, y, z), world <- body
  Eigen::MatrixXd position, velocity;          ///< m, m/s, world; zero where not recorded
  Eigen::MatrixXd rate, angular_acceleration;  ///< rad/s, rad/s^2, body
  Eigen::MatrixXd specific_force;              ///< m/s^2, body
  Eigen::MatrixXd rotor_speed;                 ///< rad/s, root of the averaged signed square: for thrust
  Eigen::MatrixXd rotor_turning;               ///< rad/s, averaged directly: for angular momentum
  Eigen::MatrixXd alpha;                       ///< rad, one column; zero where it was not recorded
};

/// Uniform grid over the time that all chosen signals share, with 3 to 15 samples per period of
/// options.grid_hz. Errors: overlap below 2 s, or above two hours.
Result<Grid> fine_grid(const ChosenSignals& signals, const std::string& file, const Options& options);

/// Resamples and smooths the chosen signals. Excludes gaps from `used`, except where `repaired` has cut them
/// already. Sets in `f` the has_* flags, kernel_s and alignment, and adds notes on missing signals.
FineMotion fine_motion(const ChosenSignals& signals, const Repaired& repaired, const Grid& grid,
                       const vehicle::Vehicle& vehicle, const Options& options, UsedSamples& used, Flight& f);

}  // namespace omniflight::diagnosis
