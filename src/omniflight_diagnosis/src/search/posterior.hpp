// Which sets of hypotheses explain the recordings, with probabilities.
#pragma once

#include <map>
#include <set>

#include "../evidence/laplace.hpp"

namespace omniflight::diagnosis {

/// One set that was asked, with its share of the posterior.
struct SetPosterior {
  std::vector<int> hypotheses;  ///< sorted indices
  std::vector<SetMember> members;
  std::vector<double> theta_deviation;  ///< of the parameters of its laws, one member after the other
  double log_joint = 0;                 ///< ln evidence plus ln prior
  double probability = 0;
};

/// An alarm is raised when the probability that nothing was left out is below this: of least expected loss
/// where a false alarm costs three times as much as an effect that is missed.
inline constexpr double kAlarm = 0.25;
/// A further effect is named beside others where smaller sets have less than this: what a law has wrong looks
/// like one.
inline constexpr double kFurther = 0.05;

struct Posterior {
  std::vector<SetPosterior> sets;  ///< the likeliest first
  SetFit nothing, best;
  double joint_of_best = 0;  ///< ln evidence plus ln prior, normalised by the noise it was found in
  double probability_of_nothing = 0;
  /// Hypothesis, and gain of its set of one against nothing [nat]; where that was not fitted, at the best
  /// point of its grid.
  std::vector<std::pair<int, double>> alone;
  bool finished = true;  ///< false: stopped before the search had ended

  bool alarm() const { return !sets.empty() && probability_of_nothing < kAlarm; }
  /// Probability that an effect with this id is there.
  double inclusion(const std::string& id, const std::vector<Hypothesis>& hypotheses) const;
};

class GridSearch;

struct SearchLimits {
  int most_members = 5;
  int threads = 1;
  std::function<bool()> stop;
};

/// Sets that promise on the grid of shapes (promising_sets), and `seed`, fitted; then the best set without
/// each of its members. Every set that is visited is kept.
Posterior search(const Evidence& evidence, GridSearch& grid, const SearchLimits& limits,
                 const std::vector<SetMember>& seed = {});

}  // namespace omniflight::diagnosis
