// What else could have explained the residual as well as the effects that were named.
#pragma once

#include <functional>

#include "costs.hpp"
#include "gate.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "workers.hpp"

namespace omniflight::diagnosis {

/// Below this cosine of contributions, whitened, another effect explains another part of the residual.
constexpr double kRival = 0.6;

/// The candidates, each fitted alone: where searches beside others start from. Fewer than the candidates
/// where time was up.
class AloneFits {
 public:
  void add(Fit fit) { fits_.push_back(std::move(fit)); }
  const std::vector<Fit>& fits() const { return fits_; }
  /// nullptr where it was not tried.
  const Fit* find(const physics::Effect* effect) const;
  /// A preview of one more effect beside those of `base`, from the values it would take alone.
  Fit quick(const Problem& problem, const Fit& base, const physics::Effect& effect, const Options& o) const;

 private:
  std::vector<Fit> fits_;
};

struct Alternative {
  std::string effect;
  std::vector<double> theta;         ///< the values it would take
  double log_likelihood_behind = 0;  ///< of the best set, penalties included; may be slightly negative
  double cosine = 0;                 ///< of the whitened contributions
};

struct Named {
  double probability = 1;
  double gain = 0;  ///< log-likelihood lost when the effect is left out
  Gate gate;
  std::vector<Alternative> set;    ///< what cannot be told apart from it
  std::vector<Alternative> alike;  ///< tells a little worse, but looks the same (whitened cosine > 0.98)
  double swapped_best = -1e18;     ///< of all other swaps, relative to the chosen set
};

/// The rivals of each member of a model.
class Alternatives {
 public:
  Alternatives(const Problem& problem, const std::vector<const physics::Effect*>& candidates,
               const Options& o, const Costs& costs, const Workers& workers, const AloneFits& alone)
      : problem_(problem), candidates_(candidates), o_(o), costs_(costs), workers_(workers), alone_(alone) {}

  /// What could stand in the place of member k; ends early when `stop` says so.
  Named of(const Fit& current, std::size_t k, const std::function<bool()>& stop) const;

 private:
  double behind_by(const Fit& current, std::size_t k, const Fit& swapped) const;
  bool bent_into_it(const Problem& problem, const Fit& fit, const Fit& rest, double least) const;

  const Problem& problem_;
  const std::vector<const physics::Effect*>& candidates_;
  const Options& o_;
  const Costs& costs_;
  const Workers& workers_;
  const AloneFits& alone_;
};

/// How well the candidates imitate each other on this flight, at the values they take alone.
AliasMatrix compare_alone(const Problem& problem, const AloneFits& alone);

}  // namespace omniflight::diagnosis
