// A motor in continuous time: speed follows what is commanded with a lag of its own up and down, after a
// delay.
#pragma once

#include "omniflight_identification/fit.hpp"

namespace omniflight::identification {

/// dy/dt = (sum_i gain_i u_i(t - delay_i) + offset - y) / lag, with lag_up while y rises and lag_down while
/// it falls. Only input 0 is delayed. Inputs are held between samples.
struct MotorDynamics {
  Eigen::VectorXd gain;                              ///< unit of y per unit of each input
  double lag_up = 0.0, lag_down = 0.0, delay = 0.0;  ///< s
  /// Variances and covariances of gain..., lag_up, lag_down, delay; with the correlation of the residuals.
  Eigen::MatrixXd covariance;
  double fit_percent = 0.0;  ///< simulation of the data it was fitted to, see fit_percent()
  bool converged = false;

  double lag() const { return 0.5 * (lag_up + lag_down); }
  double sigma_lag_up() const;  ///< s
  double sigma_lag_down() const;
  double sigma_delay() const;
};

struct DynamicsOptions {
  double max_lag_s = 2.0;
  double max_delay_s = 0.1;
  Eigen::Index transient_samples = 50;
  std::function<bool()> stop;
};

/// Output-error fit by Ceres from several starts. Every experiment has its own offset. Errors: check(), lag
/// or delay at its limit, no convergence.
Result<MotorDynamics> fit_dynamics(const Dataset& data, const DynamicsOptions& options = {});

/// Output of an experiment with the offset for which it fits best, from the measured start.
Eigen::VectorXd simulated(const MotorDynamics& motor, double period_s, const Experiment& experiment);
double fit_percent(const MotorDynamics& motor, const Dataset& data);
/// gain of input 0 / (1 + i w lag) exp(-i w delay) at w [rad/s], lag the mean of up and down.
std::complex<double> response(const MotorDynamics& motor, double w_radps);

}  // namespace omniflight::identification
