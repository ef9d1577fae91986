// Low passes and differentiation of uniformly sampled signals: without phase shift for recordings, causal for
// monitoring in flight.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// Forward-backward Butterworth low pass (4th order each way) of every column of a uniformly sampled matrix.
/// The ends are extended by point reflection. cutoff_hz must be in (0, 0.49 rate_hz); otherwise x is
/// returned.
Eigen::MatrixXd low_pass(const Eigen::MatrixXd& x, double rate_hz, double cutoff_hz);

/// Centred moving average of every column over `length` samples (both end samples count half where `length`
/// is even). Unlike a zero-phase low pass it has finite support: later noise enters over half a block only.
Eigen::MatrixXd block_mean(const Eigen::MatrixXd& x, int length);

/// Every column convolved with a symmetric, approximately Gaussian kernel of this variance [samples^2]; end
/// values are repeated.
Eigen::MatrixXd blur(const Eigen::MatrixXd& x, double variance);

/// Central difference of every column (one-sided at the ends), in units of x per second.
Eigen::MatrixXd differentiate(const Eigen::MatrixXd& x, double rate_hz);

/// 4th-order Butterworth low pass, sample by sample (the forward pass of low_pass()). The first sample after
/// a reset sets the steady state.
class CausalLowPass {
 public:
  CausalLowPass(double rate_hz, double cutoff_hz, Eigen::Index channels);
  /// Filters one sample of all channels in place; allocates nothing.
  void step(Eigen::Ref<Eigen::VectorXd> x);
  void reset() { fresh_ = true; }
  /// Group delay at zero frequency [s].
  double delay_s() const { return delay_; }

 private:
  Eigen::Matrix<double, 5, 2> coefficients_;  ///< b0 b1 b2 a1 a2 of both sections
  Eigen::MatrixXd state_;                     ///< channels x 4
  double delay_ = 0;
  bool fresh_ = true;
};

}  // namespace omniflight::diagnosis
