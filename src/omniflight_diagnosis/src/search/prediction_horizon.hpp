// How far ahead regressors are predicted: the one choice of an estimator, made once for a recording.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "../regression/regression_problem.hpp"

namespace omniflight::diagnosis {

/// Chi-square of one degree of freedom that chance exceeds once in a thousand.
inline constexpr double kHorizonsDisagree = 10.8;

/// A horizon that was asked about, and the largest of its statistics against longer ones.
struct HorizonTest {
  double horizon_s = 0;
  double statistic = 0;  ///< chi-square, one degree of freedom
  std::string about;     ///< the regressor it belongs to: "Mz of rotors"
};

struct HorizonChoice {
  std::vector<HorizonTest> tests;  ///< of every horizon that was refused, and last of the chosen one
  double horizon_s() const { return tests.back().horizon_s; }
  /// Overdispersion of the likelihood, at least 1: by how much squared standard errors must grow until the
  /// chosen horizon agrees with the one that was refused last. Where a model is right, neighbouring horizons
  /// differ by chance only; where it is not, the likelihood is surer than it may be (quasi-likelihood,
  /// Wedderburn 1974).
  double dispersion() const;
};

/// The problem with the shortest horizon whose estimates agree with those of longer ones (the idea of Hausman
/// 1978; the variance of a difference is that of its own weights on white noise): a short one is efficient,
/// but biased where feedback acts on what the recording does not tell; a long one is less so. Asked of the
/// scale of every channel's rotor wrench, and of drag along and about every axis.
std::unique_ptr<RegressionProblem> problem_of_consistent_horizon(std::span<const Flight* const> flights,
                                                                 const vehicle::Vehicle& vehicle,
                                                                 const Options& options,
                                                                 HorizonChoice& choice);

}  // namespace omniflight::diagnosis
