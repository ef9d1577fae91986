#include "alternatives.hpp"

#include <algorithm>
#include <cmath>

#include "imitation.hpp"
#include "members.hpp"
#include "nested.hpp"
#include "single_rotor.hpp"

namespace omniflight::diagnosis {

using physics::ActiveEffect;
using physics::Effect;

const Fit* AloneFits::find(const Effect* effect) const {
  const auto own = std::find_if(fits_.begin(), fits_.end(),
                                [&](const Fit& f) { return f.effects.back().effect == effect; });
  return own == fits_.end() ? nullptr : &*own;
}

Fit AloneFits::quick(const Problem& problem, const Fit& base, const Effect& effect, const Options& o) const {
  const Fit* own = find(&effect);
  return quick_with(problem, base, effect, o, own ? &own->effects.back().theta : nullptr);
}

Named Alternatives::of(const Fit& current, std::size_t k, const std::function<bool()>& stop) const {
  Named named;
  const Fit rest = fit_effects(problem_, without(current.effects, k), o_);
  const Fit frozen = frozen_without(problem_, current, k);
  named.gain = current.log_likelihood - rest.log_likelihood;
  named.gate = gate_effect(problem_, current, k, o_);
  // differences far below the gain are within what an imperfect noise model can produce
  const double temper = std::max(1.0, 0.003 * named.gain);
  const Eigen::VectorXd own = without_free_scale(
      problem_, problem_.noise().apply_vector(problem_, contribution_of(problem_, current, k)));
  std::vector<const Effect*> others;
  for (const Effect* effect : candidates_)
    if (!contains(current, effect)) others.push_back(effect);
  struct Swap {
    physics::ActiveEffect effect;
    double log_likelihood, behind, alike;
    bool no_rival;
  };
  const auto swaps = workers_.map<Swap>(
      others.size(),
      [&](const Problem& problem, std::size_t i) {
        const Effect* effect = others[i];
        Fit swapped = alone_.quick(problem, frozen, *effect, o_);
        if (declared_alias(*effect, *current.effects[k].effect) ||
            score(current, costs_) - score(swapped, costs_) < 20.0 + 6.0 * temper)
          swapped = fit_with(problem, frozen, *effect, o_);
        const double behind = behind_by(current, k, swapped);
        const double alike =
            cosine_of(without_free_scale(problem, last_columns(problem, problem.noise(), swapped)), own);
        const bool no_rival =
            alike >= kRival && behind / temper < 10.0 &&
            (bent_into_it(problem, swapped, frozen, current.log_likelihood - 3.0 * temper) ||
             only_adds_freedom(problem, current, k, swapped));
        return Swap{swapped.effects.back(), swapped.log_likelihood, behind, alike, no_rival};
      },
      stop);
  double total = 1.0;
  for (const Swap& swap : swaps) {
    named.swapped_best = std::max(named.swapped_best, -swap.behind);
    if (swap.alike < kRival) continue;
    const std::string& id = swap.effect.effect->info().id;
    const auto told = [&](const std::vector<Alternative>& list) {
      return std::any_of(list.begin(), list.end(), [&](const Alternative& a) { return a.effect == id; });
    };
    const double behind = swap.behind / temper;
    if (!swap.no_rival) total += std::exp(std::min(0.0, -behind));
    if (id == current.effects[k].effect->info().id || told(named.set)) continue;  // another rotor
    if (swap.no_rival || behind >= 10.0) continue;
    const Alternative other{id, in_full(swap.effect).theta, swap.behind, swap.alike};
    if (behind < 3.0 && swap.log_likelihood > rest.log_likelihood)
      named.set.push_back(other);
    else if (swap.alike > 0.98 && current.log_likelihood - swap.log_likelihood < 3.0 * temper &&
             !told(named.alike))
      named.alike.push_back(other);
  }
  named.probability = 1.0 / total;
  return named;
}

/// How much worse the flight is explained with the last effect of `swapped` in the place of member k. Noisy
/// rotor speeds and an inertia known to a tenth make rotors seem to turn the body less than they do: where
/// feedback colours the state, torques do not decide between a weak thrust and a load, which has none.
double Alternatives::behind_by(const Fit& current, std::size_t k, const Fit& swapped) const {
  const Effect &own = *current.effects[k].effect, &other = *swapped.effects.back().effect;
  const double all = score(current, costs_) - score(swapped, costs_);
  if (problem_.instrumented() || !declared_alias(own, other) || turns(own) == turns(other)) return all;
  const auto of_torques = [&](const Fit& fit) {
    return 0.5 *
           problem_.noise().apply_vector(problem_, fit.residual).tail(3 * problem_.samples()).squaredNorm();
  };
  return all + of_torques(current) - of_torques(swapped);
}

/// Whether the last effect of `fit` does as well as it does only at a limit: a cable of 5 cm that hangs
/// from the vehicle at every height is a payload by another name. least: the log likelihood that its usual
/// shapes must reach.
bool Alternatives::bent_into_it(const Problem& problem, const Fit& fit, const Fit& rest, double least) const {
  const ActiveEffect& e = fit.effects.back();
  if (at_limit(problem, e)) return true;
  ActiveEffect usual = e;
  bool bent = false;
  for (std::size_t k = 0; k < e.theta.size(); ++k) {
    const physics::Parameter& p = e.effect->info().parameters[k];
    if (!is_shape(p)) continue;
    const double near = 1e-3 * (p.upper - p.lower);
    bent = bent || e.theta[k] < p.lower + near || e.theta[k] > p.upper - near;
    usual.theta[k] = p.typical;
  }
  return bent && quick_with(problem, rest, *e.effect, o_, &usual.theta).log_likelihood < least;
}

AliasMatrix compare_alone(const Problem& problem, const AloneFits& alone) {
  AliasMatrix out;
  const auto m = static_cast<Eigen::Index>(alone.fits().size());
  out.cosine = Eigen::MatrixXd::Identity(m, m);
  std::vector<Eigen::MatrixXd> columns;
  std::vector<Eigen::VectorXd> contribution;
  for (Fit fit : alone.fits()) {
    ActiveEffect& e = fit.effects.back();
    for (std::size_t c = 0; c < e.theta.size(); ++c)
      if (std::abs(e.theta[c] - e.effect->info().parameters[c].neutral) < 1e-12)
        e.theta[c] = e.effect->info().parameters[c].typical;
    problem.predict(fit.effects, fit.offsets, fit.residual, nullptr);
    out.effects.push_back(e.effect->info().id);
    columns.push_back(last_columns(problem, problem.noise(), fit));
    contribution.push_back(problem.noise().apply_vector(problem, contribution_of(problem, fit, 0)));
  }
  for (Eigen::Index j = 0; j < m; ++j) {
    const Imitator imitator(columns[static_cast<std::size_t>(j)]);
    for (Eigen::Index i = 0; i < m; ++i)
      if (i != j) out.cosine(i, j) = imitator.cosine(contribution[static_cast<std::size_t>(i)]);
  }
  return out;
}

}  // namespace omniflight::diagnosis
