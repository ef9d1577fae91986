// Low passes and derivative: zero-phase for recordings (the same for the measured side and for every
// regressor), causal for what is judged in flight.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// Forward-backward Butterworth low pass (4th order each way) of every column of a uniformly sampled matrix.
/// The ends are extended by point reflection. cutoff_hz must be below rate_hz / 2; otherwise x is returned.
Eigen::MatrixXd low_pass(const Eigen::MatrixXd& x, double rate_hz, double cutoff_hz);

/// Mean of every column over `length` samples around each one (half of each end sample where that is even):
/// no sample further away than half a block has a share, unlike a zero-phase low pass.
Eigen::MatrixXd block_mean(const Eigen::MatrixXd& x, int length);

/// Every column under a symmetric bell-shaped kernel of this variance [samples^2]; the ends are held.
Eigen::MatrixXd blur(const Eigen::MatrixXd& x, double variance);

/// Central difference of every column (one-sided at the ends), per second.
Eigen::MatrixXd differentiate(const Eigen::MatrixXd& x, double rate_hz);

/// The forward half of low_pass(): 4th-order Butterworth, sample by sample. The first sample after a reset is
/// taken for the state it has rested in.
class CausalLowPass {
 public:
  CausalLowPass(double rate_hz, double cutoff_hz, Eigen::Index channels);
  /// Filters one sample of all channels in place; allocates nothing.
  void step(Eigen::Ref<Eigen::VectorXd> x);
  void reset() { fresh_ = true; }
  /// Group delay of slow signals [s].
  double delay_s() const { return delay_; }

 private:
  Eigen::Matrix<double, 5, 2> coefficients_;  ///< b0 b1 b2 a1 a2 of both sections
  Eigen::MatrixXd state_;                     ///< channels x 4
  double delay_ = 0;
  bool fresh_ = true;
};

}  // namespace omniflight::diagnosis
