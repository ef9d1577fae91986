// Autoregressive whitening, one filter a flight and channel.
#pragma once

#include <array>
#include <vector>

#include "problem.hpp"

namespace omniflight::diagnosis {

class Whitening {
 public:
  /// White with one variance a flight and channel.
  static Whitening scale_only(const Problem& problem, const Eigen::VectorXd& residual);
  /// Burg's method over the runs of each flight; fewer coefficients where a flight is short.
  static Whitening autoregressive(const Problem& problem, const Eigen::VectorXd& residual, int order);

  /// Noise of which a regression on columns[c] of channel c has left `residual`. Such columns take slow noise
  /// away with what they explain: twenty of them left three quarters of it after a minute of 0.3 s
  /// turbulence, and every significance came out a fifth too high. The autocovariances get back what a
  /// regression takes from noise of this very model (restricted maximum likelihood in effect).
  static Whitening autoregressive(const Problem& problem, const Eigen::VectorXd& residual, int order,
                                  const std::array<Eigen::MatrixXd, 6>& columns);

  /// Filtered and divided by the innovation's standard deviation; the first samples of every run become zero.
  Eigen::MatrixXd apply(const Problem& problem, const Eigen::Ref<const Eigen::MatrixXd>& x) const;
  Eigen::VectorXd apply_vector(const Problem& problem, const Eigen::VectorXd& x) const;
  /// The same for one channel only: x and out have one row a sample.
  void apply_channel(const Problem& problem, int channel, const Eigen::Ref<const Eigen::VectorXd>& x,
                     Eigen::Ref<Eigen::VectorXd> out) const;

  /// Gaussian log-likelihood of the residual it was fitted to (constants dropped).
  double log_likelihood() const { return log_likelihood_; }
  /// The same, a channel.
  const std::array<double, 6>& channel_log_likelihood() const { return per_channel_; }
  int samples() const { return samples_; }  ///< innovations, all channels

 private:
  struct Filter {
    std::vector<double> a;  ///< x_i predicted by sum a_k x_(i-1-k)
    double sigma = 1;
  };
  void finish(const Problem& problem, const Eigen::VectorXd& residual);
  void give_back(const Problem& problem, int channel, const Eigen::MatrixXd& columns);
  std::vector<std::array<Filter, 6>> filters_;  ///< a flight
  std::array<double, 6> per_channel_{};
  double log_likelihood_ = 0;
  int samples_ = 0;
  int skip_ = 0;  ///< samples dropped at the start of every run: the same for all models
};

}  // namespace omniflight::diagnosis
