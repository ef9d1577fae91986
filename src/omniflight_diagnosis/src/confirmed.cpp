#include "confirmed.hpp"

#include <algorithm>
#include <cmath>

#include "members.hpp"

namespace omniflight::diagnosis {

namespace {

constexpr double kNearlyAll = 0.9;  // of the energy of a channel

}  // namespace

std::vector<std::string> unconfirmed(const Problem& measured, const Fit& model, std::size_t candidates,
                                     const Options& o) {
  std::vector<std::string> out;
  const Costs costs(candidates, o.error_rate, measured.instrumented());
  std::vector<physics::ActiveEffect> kept = model.effects;
  while (kept.size() > 1) {
    const Fit all = fit_effects(measured, kept, o);
    std::size_t weakest = 0;
    double least = 0;
    for (std::size_t k = 0; k < kept.size(); ++k) {
      // in the noise that all of them leave: what is strong would pass for noise beside what is weak
      const double earned = gate_effect(measured, all, k, o).gain - costs.entry(*kept[k].effect);
      if (earned < least) least = earned, weakest = k;
    }
    if (!(least < 0)) break;
    out.push_back(kept[weakest].effect->info().id);
    kept = without(kept, weakest);
  }
  return out;
}

const physics::Effect* overlooked(const Problem& measured, const Fit& model,
                                  const std::vector<const physics::Effect*>& candidates, const Options& o) {
  const Fit base = fit_effects(measured, model.effects, o);
  const int n = measured.samples();
  const physics::Effect* best = nullptr;
  double most = kNearlyAll;
  for (const physics::Effect* effect : candidates) {
    if (!has_constant_columns(*effect) || contains(model, effect)) continue;
    const Fit with = fit_with(measured, base, *effect, o);
    if (!makes_sense(measured, with, with.effects.size() - 1)) continue;
    for (int c = 0; c < 6; ++c) {
      const double before = base.residual.segment(c * n, n).squaredNorm(),
                   after = with.residual.segment(c * n, n).squaredNorm();
      const double gone = std::sqrt(std::max(0.0, before - after) / n) / measured.scale(c);
      if (before - after < most * before || gone < o.min_magnitude) continue;
      most = (before - after) / before;
      best = effect;
    }
  }
  return best;
}

}  // namespace omniflight::diagnosis
