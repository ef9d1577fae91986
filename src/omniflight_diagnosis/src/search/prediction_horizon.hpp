// How far ahead regressors are predicted: the one choice of an estimator, made once for a recording.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "../evidence/noise_estimate.hpp"
#include "../numerics/statistics.hpp"
#include "../regression/regression_problem.hpp"

namespace omniflight::diagnosis {

/// Probability that chance alone makes any of the statistics of a test exceed its threshold.
inline constexpr double kHorizonsDisagree = 0.01;

/// A horizon that was asked about, and the largest of its statistics against longer ones.
struct HorizonTest {
  Horizon horizon;
  double statistic = 0;       ///< chi-square, one degree of freedom
  double of_laws = 0;         ///< the largest that belongs to a law
  int compared = 0;           ///< statistics out of which this is the largest
  std::string about;          ///< the regressor it belongs to: "Mz of rotors", or the id of a law
  bool beside_found = false;  ///< on what the best set at this horizon leaves, not on the whole residual
  /// Bonferroni's: as many as were compared may each exceed it.
  double threshold() const { return chi_squared_quantile(kHorizonsDisagree / std::max(1, compared), 1); }
  bool agrees() const { return statistic < threshold(); }
};

struct HorizonChoice {
  std::vector<HorizonTest> tests;  ///< in the order in which they were asked; last of the chosen horizon
  Horizon horizon() const { return tests.back().horizon; }
};

/// The horizons that may be chosen for these flights, and the test between them (the idea of Hausman 1978;
/// the variance of a difference is that of its own weights on white noise): a short one is efficient, but
/// biased where feedback acts on what the recording does not tell; a long one is less so, and what follows
/// from the reference alone not at all.
class Horizons {
 public:
  Horizons(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle, const Options& options);

  std::size_t count() const { return problems_.size(); }
  /// A copy, to be changed.
  std::unique_ptr<RegressionProblem> problem(std::size_t k) const;
  /// Of horizon k against all longer ones, on the residual less a known wrench (all rows, N and Nm): the
  /// scale of every channel's rotor wrench, and drag along and about every axis. An effect that was left out
  /// correlates with these differently at every horizon, and looks like feedback until it is known.
  /// So are the laws of which that wrench consists: a law that feedback mimics at this horizon has another
  /// coefficient at longer ones. Two horizons weigh samples differently, so that a law that is wrong by
  /// Options::law_error of itself has coefficients that differ, too: that is among their variance.
  HorizonTest test(std::size_t k, const Eigen::VectorXd& known, std::span<const EffectTerm> laws) const;
  /// Nothing is known.
  HorizonTest test(std::size_t k) const;

 private:
  std::vector<std::unique_ptr<RegressionProblem>> problems_;  ///< the shortest horizon first
  std::vector<Horizon> horizons_;
  SlowColumns slow_;  ///< of the first, in whose noise all are tested
  double law_error_;  ///< RMS, over a law, of what it has wrong
};

}  // namespace omniflight::diagnosis
