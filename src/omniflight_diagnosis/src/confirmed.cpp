#include "confirmed.hpp"

#include <algorithm>
#include <cmath>

#include "members.hpp"

namespace omniflight::diagnosis {

namespace {

/// What a law must take to be believed on a flight that feedback bends.
struct Least {
  double share;      ///< of the energy of a channel
  double magnitude;  ///< RMS over weight, or weight times lever
};

constexpr double kFewHz = 5;

Least least_of(const physics::Effect& effect, const Options& o) {
  return is_linear(effect) ? Least{0.9, o.min_magnitude} : Least{0.97, 10 * o.min_magnitude};
}

}  // namespace

std::vector<std::string> unconfirmed(const Problem& measured, const Fit& model, std::size_t candidates,
                                     const Options& o, std::size_t least_left) {
  std::vector<std::string> out;
  const Costs costs(candidates, o.error_rate, measured.instrumented());
  std::vector<physics::ActiveEffect> kept = model.effects;
  while (kept.size() > least_left) {
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
  const auto rms = [](const Problem& problem, const Eigen::VectorXd& residual, int c) {
    const int n = problem.samples();
    return std::sqrt(residual.segment(c * n, n).squaredNorm() / n) / problem.scale(c);
  };
  double most = 0, least_left = 1;
  for (int c = 0; c < 6; ++c) most = std::max(most, rms(measured, base.residual, c));
  const physics::Effect* best = nullptr;
  /// The least energy that is left of a channel from which it takes enough; 1 where it takes too little.
  const auto left_of = [&](const Problem& problem, const Eigen::VectorXd& all, const Fit& with,
                           const Least& least) {
    double least_of_all = 1;
    for (int c = 0; c < 6; ++c) {
      const double before = rms(problem, all, c);
      if (before < least.magnitude) continue;  // or nothing at all, where torques are not judged
      const double left = std::pow(rms(problem, with.residual, c) / before, 2);
      if (left > 1 - least.share || before * std::sqrt(1 - left) < least.magnitude) continue;
      least_of_all = std::min(least_of_all, left);
    }
    return least_of_all;
  };
  // what takes nearly all takes much of a few samples as well, and those are soon asked
  constexpr double kComesNear = 0.5;
  const Problem few = measured.thinned(base.residual, static_cast<int>(std::ceil(o.grid_hz / kFewHz)));
  const Fit few_base = fit_effects(few, {}, o);
  for (const physics::Effect* effect : candidates) {
    const Least least = least_of(*effect, o);
    if (most < least.magnitude || contains(model, effect)) continue;
    if (left_of(few, few_base.residual, fit_on_grid(few, few_base, *effect, o),
                {kComesNear * least.share, kComesNear * least.magnitude}) == 1)
      continue;
    const Fit with = fit_with(measured, base, *effect, o);
    if (!makes_sense(measured, with, with.effects.size() - 1)) continue;
    if (const double left = left_of(measured, base.residual, with, least); left < least_left) {
      least_left = left;
      best = effect;
    }
  }
  return best;
}

}  // namespace omniflight::diagnosis
