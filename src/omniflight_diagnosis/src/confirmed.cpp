#include "confirmed.hpp"

#include "members.hpp"

namespace omniflight::diagnosis {

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

}  // namespace omniflight::diagnosis
