// Linear prediction of signals from the past: the first stage of two-stage least squares.
#pragma once

#include <vector>

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// Ridge regression of each column of `targets` (n x targets) on `known` (n x regressors, the same rows; a
/// constant is added). A held or extrapolated value is no substitute for the conditional expectation: the
/// acceleration of a rotor changes sign within some samples, so that its held value predicts it with the
/// wrong sign.
///
/// Cross-fitting (Angrist, Imbens and Krueger 1999, jackknife instrumental variables): rows are divided into
/// blocks of `block` rows, every fifth block belongs to one fold, and a fold is predicted by coefficients
/// from the rows more than `apart` rows away from its blocks. In-sample coefficients would fit the noise of
/// the sample (by the ratio of regressors to samples), and the prediction would be no valid instrument. The
/// penalty is the one with the least cross-validated error, per target.
class LinearPrediction {
 public:
  LinearPrediction(const Eigen::MatrixXd& known, int block, int apart);
  /// Predictions of `targets` (n x targets), the same shape.
  Eigen::MatrixXd of(const Eigen::MatrixXd& targets) const;

 private:
  template <class Visit>
  void each_block(Eigen::Index fold, const Visit& visit) const;

  Eigen::MatrixXd X_;
  int block_, apart_;
  std::vector<std::vector<Eigen::LLT<Eigen::MatrixXd>>> factors_;  ///< per fold and penalty
};

/// LinearPrediction(known, block, apart).of(targets).
Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets, int block,
                                 int apart);

}  // namespace omniflight::diagnosis
