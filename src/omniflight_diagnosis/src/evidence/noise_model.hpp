// Noise of the wrench residual: autoregressive per flight and channel, with innovations whose slow bands may
// be stronger than the autoregression says, and heavy-tailed samples weighed down.
#pragma once

#include "../regression/regression_problem.hpp"

namespace omniflight::diagnosis {

class NoiseModel {
 public:
  /// Fitted to `rest`, what a model with `parameters` numbers left of the residual. `temperature` divides all
  /// log-likelihoods (1: as they are).
  NoiseModel(const NoiseModel&) = delete;
  NoiseModel& operator=(const NoiseModel&) = delete;
  NoiseModel(const RegressionProblem& problem, const Eigen::VectorXd& rest, int parameters, int max_order,
             double temperature);

  /// Whitened columns: filtered, weighed, as amplitudes of cosines of each stretch, over their standard
  /// deviation. Rows: whitened_rows().
  Eigen::MatrixXd apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const;
  Eigen::Index whitened_rows() const { return rows_; }
  /// Standard deviation of the innovations of a channel, mean over flights.
  double innovation(int channel) const;
  /// Sum of ln of the standard deviations: subtracted from evidences it makes those in different noise
  /// comparable.
  double log_scale() const { return log_scale_; }

 private:
  struct Filter {
    std::vector<double> a;     ///< x_i is predicted by sum_k a[k] x_(i-1-k)
    double sigma = 1;          ///< of the innovations; 0: the channel is not judged
    std::vector<double> band;  ///< standard deviation by band, in units of sigma
  };
  struct Block {  ///< one channel of one stretch
    int channel = 0, begin = 0, size = 0, kept = 0;
    Eigen::Index row = 0;
    const Filter* filter = nullptr;
    Eigen::VectorXd weight;
  };
  const RegressionProblem& problem_;
  int max_order_;
  std::vector<std::array<Filter, 6>> filters_;
  std::vector<Block> blocks_;
  Eigen::Index rows_ = 0;
  double log_scale_ = 0;
};

}  // namespace omniflight::diagnosis
