// Conditional expectation of signals given what is known before: the first stage of two-stage least squares.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// Least-squares prediction of each column of `targets` (n x targets) from `known` (n x regressors, the same
/// rows; a constant is added). A signal that is merely held, or extrapolated, need not be its expectation:
/// the rate of change of a rotor reverses within some samples, and a regression on the held one has the wrong
/// sign.
///
/// Every sample is predicted by coefficients from the rest of the stretch, a block around it and `apart`
/// samples on either side left out (cross-fitting; Angrist, Imbens and Krueger 1999, jackknife instrumental
/// variables): coefficients that saw the sample have fitted its noise as well, by the number of regressors
/// over that of samples, and the prediction would be no instrument. How strongly they shrink is what predicts
/// best.
Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets, int apart);

}  // namespace omniflight::diagnosis
