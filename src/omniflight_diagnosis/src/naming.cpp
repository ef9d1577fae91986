#include "naming.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "causality.hpp"
#include "imitation.hpp"
#include "members.hpp"
#include "shape_search.hpp"
#include "uncertainty.hpp"
#include "workers.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::Effect;

bool time_is_up(const Options& o, const char* what, Naming& naming) {
  if (!o.stopped()) return false;
  if (naming.left_out.empty() || naming.left_out.back() != what) naming.left_out.emplace_back(what);
  return true;
}

/// One search over the library: forward, backward, exchanged, split, tested.
class Search {
 public:
  Search(const Problem& problem, const std::vector<const Effect*>& candidates, const Options& o,
         const Naming* before)
      : problem_(problem),
        before_(before),
        candidates_(candidates),
        o_(o),
        costs_(candidates.size(), o.error_rate, problem.instrumented()),
        workers_(problem, o.threads) {}

  Naming run() {
    out_.asked = candidates_;
    out_.null_model = fit_effects(problem_, {}, o_);
    try_alone();
    Fit current = exchange(grow(out_.null_model, any_width()));
    current = pass(split(std::move(current)));
    out_.model = break_ties(std::move(current));
    return std::move(out_);
  }

 private:
  static int any_width() { return 1 << 20; }
  static constexpr std::size_t kMostRefused = 3;
  static constexpr double kComesNear = 0.5;              ///< of the best gain alone
  static constexpr double kAlike = 0.8;                  ///< cosine of contributions, whitened
  static constexpr double kNear = 30, kNearShare = 0.1;  ///< of the best gain, before polishing

  /// May enter: neither named nor found wanting.
  bool may_enter(const Fit& current, const Effect* effect) const {
    return !contains(current, effect) &&
           std::find(refused_.begin(), refused_.end(), effect) == refused_.end();
  }

  std::size_t tried() const { return out_.alone.fits().size(); }  // all candidates, unless time was up

  bool stop(const char* what) { return time_is_up(o_, what, out_); }

  void try_alone() {
    const auto alone = [&](const Problem& problem, std::size_t k) {
      const Fit* found = before_ ? before_->alone.find(candidates_[k]) : nullptr;
      return fit_on_grid(problem, out_.null_model, *candidates_[k], o_,
                         found ? &found->effects.back().theta : nullptr);
    };
    std::vector<Fit> fits = workers_.map<Fit>(candidates_.size(), alone,
                                              [&] { return stop("further candidates of the library"); });
    const auto gain = [&](const Fit& fit) { return fit.log_likelihood - out_.null_model.log_likelihood; };
    double best = 0;
    for (const Fit& fit : fits) best = std::max(best, gain(fit));
    struct Alone {
      Fit fit;
      double share;
    };
    auto all = workers_.map<Alone>(fits.size(), [&](const Problem& problem, std::size_t k) {
      Fit fit = std::move(fits[k]);
      // what comes near the best may be it, with its bends searched together
      if (ShapeSearch::bends_together(*candidates_[k]) && gain(fit) > kComesNear * best) {
        Fit nearer = fit_with(problem, out_.null_model, *candidates_[k], o_);
        if (nearer.log_likelihood > fit.log_likelihood) fit = std::move(nearer);
      }
      const double share = gate_effect(problem, fit, 0, o_).energy_share;
      return Alone{std::move(fit), share};
    });
    for (Alone& one : all) {
      const Effect& effect = *one.fit.effects[0].effect;
      out_.candidates.push_back({effect.info().id, gain(one.fit), costs_.entry(effect), one.share});
      out_.alone.add(std::move(one.fit));
    }
  }

  /// One more effect beside those of a model.
  struct Trial {
    double gain;
    Fit fit;
    bool blind;  ///< it may trade places with a member's shape, which only polishing shows
    bool polished = false;
  };

  static void by_gain(std::vector<Trial>& trials) {
    std::stable_sort(trials.begin(), trials.end(),
                     [](const Trial& a, const Trial& b) { return a.gain > b.gain; });
  }

  void finish(const Problem& problem, Trial& t, const Fit& current) const {
    t.fit = polish(problem, std::move(t.fit), o_);
    t.gain = score(t.fit, costs_) - score(current, costs_);
    t.polished = true;
  }

  /// What may come next, the best first, not polished yet.
  std::vector<Trial> promising(const Fit& current, int width, bool partners_too) const {
    std::vector<const Effect*> able;
    for (std::size_t k = 0; k < tried(); ++k)
      if (may_enter(current, candidates_[k]) && candidates_[k]->parameter_count() <= width)
        able.push_back(candidates_[k]);
    struct Preview {
      double gain = 0;
      bool worth = false, stuck = false, blind = false;
    };
    std::vector<Eigen::VectorXd> bent;  // what members with bends do, whitened
    for (std::size_t m = 0; partners_too && m < current.effects.size(); ++m)
      if (!is_linear(*current.effects[m].effect))
        bent.push_back(problem_.noise().apply_vector(problem_, contribution_of(problem_, current, m)));
    const auto previews = workers_.map<Preview>(able.size(), [&](const Problem& problem, std::size_t k) {
      const Fit fit = current.effects.empty() ? *out_.alone.find(able[k])
                                              : out_.alone.quick(problem, current, *able[k], o_);
      Preview p{.gain = score(fit, costs_) - score(current, costs_)};
      p.worth = tested(fit, costs_) - tested(current, costs_) > -3.0;
      p.stuck = p.worth && at_limit(problem, fit.effects.back());
      if (p.worth || bent.empty()) return p;
      const Eigen::MatrixXd own = last_columns(problem, problem.noise(), fit);
      p.blind = std::any_of(bent.begin(), bent.end(), [&](const auto& v) { return cosine_of(own, v) > 0.9; });
      return p;
    });
    std::vector<std::size_t> order, stuck;
    for (std::size_t k = 0; k < able.size(); ++k)
      if (previews[k].worth) (previews[k].stuck ? stuck : order).push_back(k);
    for (auto* list : {&order, &stuck})
      std::stable_sort(list->begin(), list->end(),
                       [&](std::size_t a, std::size_t b) { return previews[a].gain > previews[b].gain; });
    if (order.size() > 4) order.resize(4);
    // what ends at its limit would keep better ones out; beside others it may still leave it
    if (stuck.size() > 2) stuck.resize(2);
    order.insert(order.end(), stuck.begin(), stuck.end());
    for (std::size_t k = 0; k < able.size(); ++k)
      if (previews[k].blind) order.push_back(k);
    auto trials = workers_.map<Trial>(order.size(), [&](const Problem& problem, std::size_t i) {
      Fit fit = fit_with(problem, current, *able[order[i]], o_);
      const double gain = score(fit, costs_) - score(current, costs_);
      return Trial{gain, std::move(fit), previews[order[i]].blind};
    });
    by_gain(trials);
    return trials;
  }

  /// Only what is near the best can still come to be it: a law with memory takes seconds to polish.
  void polish_the_best(std::vector<Trial>& trials, const Fit& current) const {
    if (trials.empty()) return;
    const double near = trials.front().gain - std::max(kNear, kNearShare * std::abs(trials.front().gain));
    std::vector<std::size_t> chosen;
    for (std::size_t k = 0; k < trials.size(); ++k)
      if (trials[k].blind || trials[k].gain > near) chosen.push_back(k);
    auto polished = workers_.map<Trial>(chosen.size(), [&](const Problem& problem, std::size_t i) {
      Trial t = trials[chosen[i]];
      finish(problem, t, current);
      return t;
    });
    for (std::size_t i = 0; i < chosen.size(); ++i) trials[chosen[i]] = std::move(polished[i]);
    by_gain(trials);
  }

  /// Adds the effect that gains most until none earns its parameters, of laws with at most `width` of them.
  Fit grow(Fit current, int width) {
    for (int step = 0; step < o_.max_effects; ++step) {
      if (step > 0 && stop("a search for further effects")) break;
      std::vector<Trial> trials = promising(current, width, step > 0);
      polish_the_best(trials, current);
      bool entered = false;
      while (!trials.empty()) {
        Trial& best = trials.front();
        if (!best.polished) {  // those before it were refused
          finish(problem_, best, current);
          by_gain(trials);
          continue;
        }
        std::size_t index = 0;  // polishing may have moved the newcomer
        while (contains(current, best.fit.effects[index].effect)) ++index;
        if (tested(best.fit, costs_) > tested(current, costs_) && makes_sense(problem_, best.fit, index) &&
            gate_open(problem_, gate_effect(problem_, best.fit, index, o_), o_,
                      costs_.entry(*best.fit.effects[index].effect))) {
          const double before = tested(current, costs_);
          current = prune(problem_, std::move(best.fit), o_, costs_);
          entered = tested(current, costs_) > before + 1e-6;
          break;
        }
        trials.erase(trials.begin());
      }
      if (!entered) break;
    }
    return current;
  }

  /// The log-likelihood by which `rest` and one more have this score.
  double needed(const Fit& rest, const Effect& effect, double to_score) const {
    return to_score + rest.log_likelihood - score(rest, costs_) + costs_.complexity(effect);
  }

  /// A candidate beside `rest` in the place of member k, where that is better.
  std::optional<Fit> swapped_in(const Problem& problem, const Fit& current, std::size_t k, const Fit& rest,
                                const Effect& effect, int width) const {
    if (!may_enter(current, &effect) || effect.parameter_count() > width) return std::nullopt;
    const double now = score(current, costs_);
    if (!declared_alias(effect, *current.effects[k].effect) &&
        score(out_.alone.quick(problem, rest, effect, o_), costs_) < now - 5.0)
      return std::nullopt;
    // products bend into constants: a wind of 5 m/s on next to no area is a steady pull
    const bool bends = is_linear(*current.effects[k].effect) && !is_linear(effect);
    const double gain = current.log_likelihood - rest.log_likelihood;
    const double least = now + (bends ? std::max(3.0, 0.01 * gain) : 1.0);
    Fit swapped = fit_with(problem, rest, effect, o_, needed(rest, effect, least));
    if (score(swapped, costs_) < least) return std::nullopt;
    return swapped;
  }

  /// A member for another candidate, while that is better.
  Fit exchange(Fit current, int width = any_width()) {
    for (int round = 0; round < 3; ++round) {
      if (current.effects.empty() || stop("exchanges of named effects")) break;
      bool better = false;
      for (std::size_t k = 0; k < current.effects.size() && !better; ++k) {
        const Fit rest = fit_effects(problem_, without(current.effects, k), o_);
        const auto swaps = workers_.map<std::optional<Fit>>(
            candidates_.size(), [&](const Problem& problem, std::size_t i) -> std::optional<Fit> {
              return swapped_in(problem, current, k, rest, *candidates_[i], width);
            });
        for (std::size_t i = 0; i < candidates_.size() && !better; ++i) {
          if (!swaps[i]) continue;
          const Effect* const effect = candidates_[i];
          const Fit& swapped = *swaps[i];
          if (!makes_sense(problem_, swapped, swapped.effects.size() - 1) ||
              !gate_open(problem_, gate_effect(problem_, swapped, swapped.effects.size() - 1, o_), o_,
                         costs_.entry(*effect)))
            continue;
          current = prune(problem_, polish(problem_, swapped, o_), o_, costs_);
          better = true;
        }
      }
      if (!better) break;
    }
    return current;
  }

  /// A law with many parameters can be two simple ones at once: a cable with an offset centre of mass bends a
  /// load on a rope into itself. Simple laws that do nearly as well with no more numbers take its place.
  Fit split(Fit current) {
    const auto rich = [](const ActiveEffect& e) { return is_rich(*e.effect); };
    if (std::none_of(current.effects.begin(), current.effects.end(), rich)) return current;
    if (stop("simpler laws in place of a rich one")) return current;
    std::vector<ActiveEffect> kept = current.effects;
    std::erase_if(kept, rich);
    const Fit rest = fit_effects(problem_, kept, o_);
    Fit simple = exchange(grow(rest, kFewNumbers), kFewNumbers);
    const double gain = current.log_likelihood - rest.log_likelihood;
    const double slack = simple.parameters <= current.parameters ? std::max(3.0, 0.05 * gain) : 0.0;
    return score(simple, costs_) > score(current, costs_) - slack ? simple : current;
  }

  /// Those that pass, and what grows in the place of those that do not: a law that imitates another best need
  /// not stand on its own, and the other was never asked then.
  Fit pass(Fit current) {
    for (;;) {
      const std::size_t before = refused_.size();
      const Fit with = current;
      current = keep_what_passes(std::move(current));
      if (refused_.size() == before || refused_.size() > kMostRefused ||
          stop("laws in place of those that did not pass"))
        return current;
      current = problem_.instrumented() ? exchange(grow(std::move(current), any_width()))
                                        : stand_in(std::move(current), with, before);
    }
  }

  /// Where feedback colours the state, enough stands in line that would only seem to pass: only what acts as
  /// a refused member of `with` did is asked. A single weak rotor lowers the thrust as a load does, and bends
  /// a little besides.
  Fit stand_in(Fit current, const Fit& with, std::size_t before) {
    std::vector<std::pair<double, const Effect*>> order;
    for (std::size_t k = 0; k < with.effects.size(); ++k) {
      if (std::find(refused_.begin() + static_cast<std::ptrdiff_t>(before), refused_.end(),
                    with.effects[k].effect) == refused_.end())
        continue;
      const Eigen::VectorXd own = problem_.noise().apply_vector(problem_, contribution_of(problem_, with, k));
      const bool answered = answers_instead_of_causing(problem_, with, k, o_);
      for (const Effect* effect : candidates_) {
        if (!may_enter(current, effect)) continue;
        const Fit fit = out_.alone.quick(problem_, current, *effect, o_);
        if (!(tested(fit, costs_) > tested(current, costs_)) || at_limit(problem_, fit.effects.back()))
          continue;
        const Eigen::MatrixXd columns = last_columns(problem_, problem_.noise(), fit);
        // its torques were an answer to something else: what gives none may stand for its forces
        const Eigen::Index rows = (answered && !turns(*effect) ? 3 : 6) * problem_.samples();
        if (cosine_of(columns.topRows(rows), own.head(rows)) > kAlike)
          order.emplace_back(score(fit, costs_), effect);
      }
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) {  // the simplest, then the best
                       const int more = a.second->parameter_count() - b.second->parameter_count();
                       return more != 0 ? more < 0 : a.first > b.first;
                     });
    for (const auto& [preview, effect] : order) {
      if (stop("laws in place of those that did not pass")) break;
      Fit fit = fit_with(problem_, current, *effect, o_);
      const std::size_t last = fit.effects.size() - 1;
      if (tested(fit, costs_) > tested(current, costs_) && makes_sense(problem_, fit, last) &&
          gate_open(problem_, gate_effect(problem_, fit, last, o_), o_, costs_.entry(*effect)))
        return polish(problem_, std::move(fit), o_);
    }
    return current;
  }

  /// Every member must pass in the company of the others; the others are not tried again.
  Fit keep_what_passes(Fit current) {
    const auto take_out = [&](std::size_t index) {
      refused_.push_back(current.effects[index].effect);
      current = polish(problem_, fit_effects(problem_, without(current.effects, index), o_), o_);
    };
    for (std::size_t k = 0; k < current.effects.size();) {  // first: it bends what the others are judged by
      if (answers_instead_of_causing(problem_, current, k, o_))
        take_out(k), k = 0;
      else
        ++k;
    }
    while (!current.effects.empty()) {
      bool all_pass = true;
      double worst = 0;
      std::size_t index = 0;
      const Fit settled = settle(problem_, current, o_);
      const Uncertainty known = uncertainty_of(problem_, settled);
      std::vector<Gate> gates;
      std::vector<double> gains;
      for (std::size_t k = 0; k < current.effects.size(); ++k) {
        gates.push_back(gate_effect(problem_, current, k, o_));
        gains.push_back(gates.back().gain);
      }
      constexpr double kAway = 2.5;
      Eigen::Index at = 0;
      for (std::size_t k = 0; k < current.effects.size(); ++k) {
        const Gate& gate = gates[k];
        bool away =
            known.distance[k] > kAway;  // from nothing, by more than noise and tolerances together allow
        for (std::size_t c = 0; c < current.effects[k].theta.size(); ++c, ++at) {
          const physics::Parameter& p = current.effects[k].effect->info().parameters[c];
          away = away ||
                 (!is_shape(p) && std::abs(settled.effects[k].theta[c] - p.neutral) > kAway * known.se[at]);
        }
        away = away && makes_sense(problem_, current, k) && !at_limit(problem_, settled.effects[k]) &&
               !mends_another(current, k, gains);
        if (away && gate_open(problem_, gate, o_, costs_.entry(*current.effects[k].effect))) continue;
        if (all_pass || gate.gain < worst) worst = gate.gain, index = k;
        all_pass = false;
      }
      if (all_pass) break;
      take_out(index);
    }
    return current;
  }

  /// A tie within what the noise model can be trusted goes to the effect that stands first in the catalogue
  /// and is no richer, or that comes with another one, or that must be there.
  Fit break_ties(Fit current) {
    for (std::size_t k = 0; k < current.effects.size() && !stop("ties between effects"); ++k) {
      const double gain =
          current.log_likelihood - fit_effects(problem_, without(current.effects, k), o_).log_likelihood;
      const Eigen::VectorXd own = without_free_scale(
          problem_, problem_.noise().apply_vector(problem_, contribution_of(problem_, current, k)));
      bool earlier = true;
      for (const Effect* effect : candidates_) {
        earlier = earlier && effect != current.effects[k].effect;
        // a law with many more parameters can bend itself into nearly anything, products into constants
        const int more = current.effects[k].effect->parameter_count() - effect->parameter_count();
        const bool straight = more >= 0 && is_linear(*effect) && !is_linear(*current.effects[k].effect);
        const bool simpler = more >= 3 || straight;
        // the floor lifts whoever leaves it; its height law is an idealised one
        const bool certain = problem_.took_off() && effect->info().id == "ground_effect";
        const bool usual = certain || comes_with_another(*effect, current, k);
        if (effect == current.effects[k].effect || (!(earlier && more >= 0) && !simpler && !usual)) continue;
        if (!may_enter(current, effect)) continue;
        const double slack = certain ? std::max(tie(gain, more), kLawKnown * gain) : tie(gain, more);
        const Fit frozen = frozen_without(problem_, current, k);
        if (!declared_alias(*effect, *current.effects[k].effect) &&
            score(out_.alone.quick(problem_, frozen, *effect, o_), costs_) <
                score(current, costs_) - slack - 10.0)
          continue;
        const double least = score(current, costs_) - slack;
        Fit swapped = fit_with(problem_, frozen, *effect, o_, needed(frozen, *effect, least));
        if (score(swapped, costs_) < least) continue;
        if (!makes_sense(problem_, swapped, swapped.effects.size() - 1)) continue;
        if (cosine_of(without_free_scale(problem_, last_columns(problem_, problem_.noise(), swapped)), own) <
            (usual       ? kRival
             : more >= 3 ? 0.8
             : straight  ? 0.9
                         : 0.98))
          continue;
        std::rotate(swapped.effects.begin() + static_cast<std::ptrdiff_t>(k), swapped.effects.end() - 1,
                    swapped.effects.end());
        current = std::move(swapped);
        break;
      }
    }
    return current;
  }

  const Problem& problem_;
  const Naming* before_;
  const std::vector<const Effect*>& candidates_;
  const Options& o_;
  const Costs costs_;
  const Workers workers_;
  Naming out_;
  std::vector<const Effect*> refused_;
};

}  // namespace

Naming name_effects(const Problem& problem, const std::vector<const Effect*>& candidates, const Options& o,
                    const Naming* before) {
  return Search(problem, candidates, o, before).run();
}

void tell_rivals(const Problem& problem, const Options& o, Naming& naming) {
  const auto stop = [&](const char* what) { return time_is_up(o, what, naming); };
  if (!stop("profiles of the laws' bends")) naming.model = profile_shapes(problem, naming.model, o);
  const Costs costs(naming.asked.size(), o.error_rate, problem.instrumented());
  const Workers workers(problem, o.threads);
  const Alternatives alternatives(problem, naming.asked, o, costs, workers, naming.alone);
  naming.named.clear();
  for (std::size_t k = 0; k < naming.model.effects.size(); ++k)
    naming.named.push_back(
        alternatives.of(naming.model, k, [&] { return stop("alternatives to the named effects"); }));
  naming.aliases = compare_alone(problem, naming.alone);
}

}  // namespace omniflight::diagnosis
