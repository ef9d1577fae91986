#include "members.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {

std::vector<physics::ActiveEffect> without(const std::vector<physics::ActiveEffect>& effects,
                                           std::size_t index) {
  std::vector<physics::ActiveEffect> out = effects;
  out.erase(out.begin() + static_cast<std::ptrdiff_t>(index));
  return out;
}

bool contains(const Fit& fit, const physics::Effect* effect) {
  return std::any_of(fit.effects.begin(), fit.effects.end(),
                     [&](const physics::ActiveEffect& e) { return e.effect == effect; });
}

// of the energy of the best channel
constexpr double kMuch = 0.2, kMost = 0.5, kNearlyAll = 0.95;
constexpr double kSure = 3, kVerySure = 20;  // times what chance asks for

bool gate_open(const Problem& problem, const Gate& gate, const Options& o, double needed) {
  // blocks differ most where an effect acts for moments only; what leaves next to nothing is seen all the
  // same
  const double least = problem.instrumented() || gate.energy_share > kNearlyAll ? 0.0 : 2.0;
  const bool shows = problem.instrumented() ? std::max(gate.energy_share, gate.prominence) > 0.5 * o.min_share
                                            : gate.energy_share > o.min_share;
  // small, yet much of what is there: without a name it would be called unknown
  const bool much = gate.energy_share > kMuch && gate.gain > kSure * needed && gate.cross_validated_se > 2,
             most = gate.energy_share > kMost && gate.gain > kVerySure * needed;
  const bool sure = problem.instrumented() && (much || most) && gate.removed > kAccuracy;
  return gate.gain > needed && gate.cross_validated_se > least && shows &&
         (sure || gate.magnitude > o.min_magnitude);
}

namespace {

bool cancels_another(const Problem& problem, const Fit& fit, std::size_t index) {
  const auto scaled = [&](std::size_t k) {
    Eigen::VectorXd x = contribution_of(problem, fit, k);
    for (int c = 0; c < 6; ++c) x.segment(c * problem.samples(), problem.samples()) /= problem.scale(c);
    return x;
  };
  const Eigen::VectorXd own = scaled(index);
  for (std::size_t k = 0; k < fit.effects.size(); ++k) {
    if (k == index) continue;
    const Eigen::VectorXd other = scaled(k);
    const double a = own.norm(), b = other.norm();
    if (own.dot(other) < -0.9 * a * b && std::min(a, b) > 0.3 * std::max(a, b)) return true;
  }
  return false;
}

}  // namespace

bool makes_sense(const Problem& problem, const Fit& fit, std::size_t index) {
  return !at_limit(problem, fit.effects[index]) && !cancels_another(problem, fit, index);
}

Fit polish(const Problem& problem, Fit fit, const Options& o) {
  for (std::size_t k = 0; k < fit.effects.size(); ++k) {
    if (is_linear(*fit.effects[k].effect)) continue;
    const Fit rest = fit_effects(problem, without(fit.effects, k), o);
    const double least = fit.log_likelihood + 0.1;
    const Fit again = fit_with(problem, rest, *fit.effects[k].effect, o, least);
    if (again.log_likelihood > least) fit = again;
  }
  return fit;
}

bool declared_alias(const physics::Effect& a, const physics::Effect& b) {
  const auto lists = [](const physics::Effect& x, const physics::Effect& y) {
    const auto& all = x.info().aliases;
    return std::find(all.begin(), all.end(), y.info().id) != all.end();
  };
  return lists(a, b) || lists(b, a);
}

bool comes_with_another(const physics::Effect& effect, const Fit& fit, std::size_t k) {
  const auto& usual = effect.info().comes_with;
  if (!declared_alias(effect, *fit.effects[k].effect)) return false;
  return std::any_of(fit.effects.begin(), fit.effects.end(), [&](const physics::ActiveEffect& other) {
    return std::find(usual.begin(), usual.end(), other.effect->info().id) != usual.end();
  });
}

bool mends_another(const Fit& fit, std::size_t k, const std::vector<double>& gains) {
  const auto remembers = [](const physics::Effect& e) { return e.memory_size().total() > 0; };
  const physics::Effect& rich = *fit.effects[k].effect;
  if (!remembers(rich) || !is_rich(rich)) return false;
  for (std::size_t m = 0; m < fit.effects.size(); ++m) {
    const physics::Effect& simple = *fit.effects[m].effect;
    if (m == k || remembers(simple) || !declared_alias(rich, simple)) continue;
    double together = gains[m];
    for (std::size_t other = 0; other < fit.effects.size(); ++other) {
      const auto& usual = fit.effects[other].effect->info().comes_with;
      if (other != k && other != m && std::find(usual.begin(), usual.end(), simple.info().id) != usual.end())
        together += gains[other];
    }
    if (gains[k] < kLawKnown * together) return true;
  }
  return false;
}

bool turns(const physics::Effect& effect) {
  const auto& channels = effect.info().channels;
  return std::any_of(channels.begin(), channels.end(), [](const std::string& c) { return c.front() == 'M'; });
}

Fit frozen_without(const Problem& problem, const Fit& fit, std::size_t index) {
  Fit out = fit;
  out.effects = without(fit.effects, index);
  out.parameters = fit.parameters - fit.effects[index].effect->parameter_count();
  problem.predict(out.effects, out.offsets, out.residual, nullptr);
  return out;
}

Fit prune(const Problem& problem, Fit fit, const Options& o, const Costs& costs) {
  for (bool again = true; again && !fit.effects.empty();) {
    again = false;
    double best = tested(fit, costs);
    Fit chosen;
    for (std::size_t k = 0; k < fit.effects.size(); ++k) {
      Fit smaller = fit_effects(problem, without(fit.effects, k), o);
      if (tested(smaller, costs) > best) {
        best = tested(smaller, costs);
        chosen = std::move(smaller);
        again = true;
      }
    }
    if (again) fit = polish(problem, std::move(chosen), o);
  }
  return fit;
}

}  // namespace omniflight::diagnosis
