// Conditional expectation of signals given what is known before: the first stage of two-stage least squares.
#pragma once

#include <vector>

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
class LinearPrediction {
 public:
  LinearPrediction(const Eigen::MatrixXd& known, int block, int apart);
  /// Of other targets from what is known.
  Eigen::MatrixXd of(const Eigen::MatrixXd& targets) const;

 private:
  template <class Visit>
  void each_block(Eigen::Index fold, const Visit& visit) const;

  Eigen::MatrixXd X_;
  int block_, apart_;
  std::vector<std::vector<Eigen::LLT<Eigen::MatrixXd>>> factors_;  ///< a fold and ridge
};

/// The same where only these targets are asked for.
Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets, int block,
                                 int apart);

}  // namespace omniflight::diagnosis
