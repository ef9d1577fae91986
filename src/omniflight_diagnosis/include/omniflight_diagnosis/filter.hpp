// Zero-phase low pass and derivative: the same for the measured side and for every regressor.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// Forward-backward Butterworth low pass (4th order each way) of every column of a uniformly sampled matrix.
/// The ends are extended by point reflection. cutoff_hz must be below rate_hz / 2; otherwise x is returned.
Eigen::MatrixXd low_pass(const Eigen::MatrixXd& x, double rate_hz, double cutoff_hz);

/// Central difference of every column (one-sided at the ends), per second.
Eigen::MatrixXd differentiate(const Eigen::MatrixXd& x, double rate_hz);

}  // namespace omniflight::diagnosis
