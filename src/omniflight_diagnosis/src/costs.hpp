// What an effect must gain to be named, and what it costs to be richer than another.
#pragma once

#include "fit.hpp"

namespace omniflight::diagnosis {

/// What effects cost. On instruments, where chance alone decides, a law with k numbers enters when it gains
/// what chance reaches in one of m/p tries: half the upper p/m quantile of the chi-squared distribution with
/// k degrees of freedom. Where feedback and what a vehicle file does not know have their part, it must gain
/// ln(m/p), and 3 for every further number. Between laws that may all enter, every further number costs 3 in
/// any case, more than that quantile asks for: rich laws bend into anything.
class Costs {
 public:
  /// candidates: m, error_rate: p, instrumented: see Problem::instrumented().
  Costs(std::size_t candidates, double error_rate, bool instrumented);
  /// Log-likelihood that an effect must bring to be named.
  double entry(const physics::Effect& effect) const;
  /// Of all members.
  double entry(const Fit& fit) const;
  /// Between effects that may all enter.
  double complexity(const physics::Effect& effect) const;

 private:
  std::vector<double> entry_;  ///< by number of parameters less one
};

/// The likelihood less what the members' numbers cost: compares sets of effects.
double score(const Fit& fit, const Costs& costs);
/// What is left of the likelihood when every member has paid for its entry.
double tested(const Fit& fit, const Costs& costs);

/// Nats by which a law with `fewer` parameters less may explain a flight worse than one that gains `gain` and
/// still take its place: what an imperfect model of the noise can produce, and some for simplicity. Of a
/// great gain a tenth is no tie any more: a load in a cable's place left a newton at two heights unexplained.
double tie(double gain, int fewer);

}  // namespace omniflight::diagnosis
