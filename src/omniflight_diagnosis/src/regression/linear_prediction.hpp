// Conditional expectation of signals given what is known before: the first stage of two-stage least squares.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// Least-squares prediction of each column of `targets` (n x targets) from `known` (n x regressors, the same
/// rows; a constant is added). A signal that is merely held, or extrapolated, need not be its expectation:
/// the rate of change of a rotor reverses within some samples, and a regression on the held one has the wrong
/// sign.
///
/// Every sample is predicted by coefficients from other samples: rows are taken in blocks of `block` rows,
/// every fifth block belongs to one fold, and a fold is predicted by all rows that are more than `apart` rows
/// away from its blocks (cross-fitting; Angrist, Imbens and Krueger 1999, jackknife instrumental variables).
/// Coefficients that saw the sample have fitted its noise as well, by the number of regressors over that of
/// samples, and the prediction would be no instrument. How strongly they shrink (ridge) is what predicts
/// best.
Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets, int block,
                                 int apart);

}  // namespace omniflight::diagnosis
