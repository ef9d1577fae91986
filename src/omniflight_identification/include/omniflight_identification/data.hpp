// Recorded inputs and outputs on a uniform time base.
#pragma once

#include <Eigen/Dense>
#include <utility>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::identification {

/// One uninterrupted stretch of samples, one row a sample.
struct Experiment {
  Eigen::VectorXd y;  ///< output, for a motor its speed [rad/s]
  Eigen::MatrixXd u;  ///< a column an input, each in its own unit
};

/// Experiments of one system, sampled with one period. Their order says nothing.
struct Dataset {
  double period_s = 0.0;
  std::vector<Experiment> experiments;

  Eigen::Index samples() const;  ///< of all experiments together
  Eigen::Index inputs() const;   ///< 0 without experiments
};

/// Period positive; at least one experiment; every one with the same number of inputs (1 to 4), 50 to 2
/// million finite samples, and rows of y and u that match. An input that does not move is refused by name.
Status check(const Dataset& data);

enum class Trend {
  mean,  ///< the operating point
  line   ///< operating point and drift, least squares
};

/// Every experiment and every signal of it without its mean or its line.
Dataset detrended(Dataset data, Trend trend);

/// The first `share` (0 to 1) of every experiment, and the rest of it.
std::pair<Dataset, Dataset> split(const Dataset& data, double share);

}  // namespace omniflight::identification
