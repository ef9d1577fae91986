// Evidence of a set by itself: in the noise that it leaves, at the accelerations that the vehicle has with
// it.
#pragma once

#include "../evidence/laplace.hpp"
#include "../evidence/noise_estimate.hpp"

namespace omniflight::diagnosis {

/// Sets that are asked in their own noise to the end.
inline constexpr std::size_t kTried = 4;

/// ln evidence plus ln prior of a set in the noise that it leaves itself, beside the tolerances that are
/// likeliest with it, and that set fitted there.
struct Profile {
  std::unique_ptr<NoiseModel> noise;
  Eigen::VectorXd tolerances;  ///< over the problem's
  Eigen::VectorXd expected;    ///< N and Nm, all rows: what the set and the calibration beside it do
  SetFit fit;
  double joint = -1e300;
};

class Profiler {
 public:
  Profiler(const RegressionProblem& problem, const std::vector<Hypothesis>& hypotheses,
           const SlowColumns& slow, const FittedAmplitudes& fitted, const Options& o)
      : problem_(problem), hypotheses_(hypotheses), slow_(slow), fitted_(fitted), o_(o) {}

  Profile of(std::vector<SetMember> members, const Eigen::VectorXd& tolerances) const;
  /// The best of these sets, each by itself. Only those that lead after the first turn go on.
  Profile best_of(const std::vector<std::vector<SetMember>>& sets, const Eigen::VectorXd& tolerances) const;

 private:
  void turn(Profile& profile) const;
  void fit(const RegressionProblem& problem, Profile& profile) const;

  const RegressionProblem& problem_;
  const std::vector<Hypothesis>& hypotheses_;
  const SlowColumns& slow_;
  const FittedAmplitudes& fitted_;
  const Options& o_;
};

}  // namespace omniflight::diagnosis
