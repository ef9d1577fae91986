#include "confirmed.hpp"

#include <algorithm>
#include <cmath>

#include "members.hpp"
#include "shape_search.hpp"

namespace omniflight::diagnosis {

namespace {

/// What a law must take to be believed on a flight that feedback bends.
struct Least {
  double share;      ///< of the energy of a channel
  double magnitude;  ///< RMS over weight, or weight times lever
};

Least least_of(const physics::Effect& effect, const Options& o) {
  return is_linear(effect) ? Least{0.9, o.min_magnitude} : Least{0.97, 10 * o.min_magnitude};
}

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
  const auto rms = [&](const Eigen::VectorXd& residual, int c) {
    return std::sqrt(residual.segment(c * n, n).squaredNorm() / n) / measured.scale(c);
  };
  double most = 0, least_left = 1;
  for (int c = 0; c < 6; ++c) most = std::max(most, rms(base.residual, c));
  const physics::Effect* best = nullptr;
  /// The least energy that is left of a channel from which it takes enough; 1 where it takes too little.
  const auto left_of = [&](const Fit& with, const Least& least) {
    double least_of_all = 1;
    for (int c = 0; c < 6; ++c) {
      const double before = rms(base.residual, c);
      if (before < least.magnitude) continue;  // or nothing at all, where torques are not judged
      const double left = std::pow(rms(with.residual, c) / before, 2);
      if (left > 1 - least.share || before * std::sqrt(1 - left) < least.magnitude) continue;
      least_of_all = std::min(least_of_all, left);
    }
    return least_of_all;
  };
  // of the share that is asked for: the bends of a law are then searched together
  constexpr double kComesNear = 0.5;
  for (const physics::Effect* effect : candidates) {
    const Least least = least_of(*effect, o);
    if (most < least.magnitude || contains(model, effect)) continue;
    if (ShapeSearch::bends_together(*effect) &&
        left_of(fit_on_grid(measured, base, *effect, o), {kComesNear * least.share, least.magnitude}) == 1)
      continue;
    const Fit with = fit_with(measured, base, *effect, o);
    if (!makes_sense(measured, with, with.effects.size() - 1)) continue;
    if (const double left = left_of(with, least); left < least_left) {
      least_left = left;
      best = effect;
    }
  }
  return best;
}

}  // namespace omniflight::diagnosis
