// Conditional expectation of signals given what is known before: the first stage of two-stage least squares.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// Least-squares prediction of each column of `targets` (n x targets) from `known` (n x regressors, the same
/// rows; a constant is added). A signal that is merely held, or extrapolated, need not be its expectation:
/// the rate of change of a rotor reverses within some samples, and a regression on the held one has the wrong
/// sign.
Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets);

}  // namespace omniflight::diagnosis
