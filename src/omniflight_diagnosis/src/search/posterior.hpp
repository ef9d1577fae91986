// Which sets of hypotheses explain the recordings, with probabilities.
#pragma once

#include <array>
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
  double log_prior = 0;  ///< without the choice among frequencies, which is part of the evidence
  double probability = 0;
  double sharp_share = 0;  ///< of those that are not empty, were laws as right as Options::law_error says
};

/// An effect is named when the probability that nothing was left out is below this: of least expected loss
/// where a false alarm costs three times as much as an effect that is missed.
inline constexpr double kAlarm = 0.25;
/// One more beside others is named when it is likelier to be there than not, and the
/// flight speaks for it.
inline constexpr double kBeside = 0.5;

/// RMS errors of laws over law_error, equally likely before the flight, where one set of laws is compared
/// with another.
inline constexpr std::array<double, 3> kRivalErrors{1, 2, 4};

struct Posterior {
  std::vector<SetPosterior> sets;  ///< the likeliest first
  SetFit nothing, best;
  double joint_of_best = 0;     ///< ln evidence plus ln prior, normalised by the noise it was found in
  double joint_of_nothing = 0;  ///< the same of the empty set, in its own noise
  double probability_of_nothing = 0;
  /// Square of each whitened amplitude of what the best set does: over the variance of what it leaves there.
  Eigen::ArrayXd energy;
  /// What laws that are wrong leave of that [nat]: against nothing, and against other laws where both are
  /// wrong by kRivalErrors.
  double left_by_laws = 0;
  std::array<double, kRivalErrors.size()> left_between_laws{};
  /// Probability of each of kRivalErrors.
  std::array<double, kRivalErrors.size()> probability_of_error{1.0 / 3, 1.0 / 3, 1.0 / 3};
  /// Hypothesis, and gain of its set of one against nothing [nat]; where that was not fitted, at the best
  /// point of its grid.
  std::vector<std::pair<int, double>> alone;
  bool finished = true;  ///< false: stopped before the search had ended

  /// Whether a set is a candidate for what is there: one that nothing at all is likelier than is none. Its
  /// probability is that of something that no set has right.
  bool is_candidate(const SetPosterior& s) const { return s.log_joint > joint_of_nothing; }
  bool alarm() const { return !sets.empty() && probability_of_nothing < kAlarm; }
  /// Probability that an effect with this id is there.
  double inclusion(const std::string& id, const std::vector<Hypothesis>& hypotheses) const;
};

class GridSearch;

struct SearchLimits {
  int most_members = 5;
  bool load_starts = true;  ///< laws with initial states are fitted alone at some points of their grid
  int threads = 1;
  std::function<bool()> stop;
};

/// Probabilities of kRivalErrors, times law_error: an error leaves its square of the energy in an amplitude,
/// `rest` is what is left there [both whitened], and noise leaves a variance of 1/temperature.
std::array<double, kRivalErrors.size()> probability_of_errors(double law_error, const Eigen::ArrayXd& energy,
                                                              const Eigen::ArrayXd& rest, double temperature);

/// Shares one among the sets. A law that is right within law_error [1] leaves the square of it of what it
/// explains, and another law may take that by chance: a difference of ln evidence to nothing counts divided
/// by one plus that part of the largest gain, where an error leaves no more of an amplitude than is there
/// (Posterior::energy). Between sets of laws both are wrong, by kRivalErrors times law_error: the mean over
/// these, by their probabilities.
void share_probability(double law_error, Posterior& posterior);

/// Sets that promise on the grid of shapes (promising_sets), and `seed`, fitted; then the best set without
/// each of its members. Every set that is visited is kept, without a probability yet: share_probability().
Posterior search(const Evidence& evidence, GridSearch& grid, const SearchLimits& limits,
                 const std::vector<SetMember>& seed = {});

}  // namespace omniflight::diagnosis
