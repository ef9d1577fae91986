#include "ground_law.hpp"

#include <algorithm>
#include <cmath>

#include "bursts.hpp"

namespace omniflight::diagnosis {
namespace {

/// Samples [begin, end) of one stay close to the floor.
std::vector<std::pair<int, int>> passes_of(const Problem& p) {
  std::vector<std::pair<int, int>> out;
  for (const Run& run : p.runs())
    for (int i = run.begin; i < run.end; ++i) {
      const physics::Situation& x = p.situation(i);
      const double height = x.body.p_WB.z() - x.environment.floor_z;
      if (x.rotor_count == 0 || height > 3 * x.rotors[0].radius)
        continue;  // beyond, it lifts by half a per cent
      const bool goes_on = !out.empty() && out.back().second > run.begin &&
                           p.situation(i).t - p.situation(out.back().second - 1).t < 0.5;
      if (goes_on)
        out.back().second = i + 1;
      else
        out.emplace_back(i, i + 1);
    }
  std::erase_if(out,
                [&](const auto& s) { return p.situation(s.second - 1).t - p.situation(s.first).t < 0.2; });
  return out;
}

}  // namespace

bool follows_ground_law(const Problem& problem, double per_parameter, const Options& o) {
  const physics::Effect* effect = physics::find_effect("ground_effect");
  const auto passes = passes_of(problem);
  int low = 0;
  for (const auto& [begin, end] : passes) low += end - begin;
  if (!effect || passes.size() < 2 || 5 * low > 2 * problem.samples()) return false;
  const Fit without = fit_effects(problem, {}, o);
  const Fit fit = fit_with(problem, without, *effect, o);
  if (at_limit(problem, fit.effects.back()) || fit.log_likelihood - without.log_likelihood < per_parameter)
    return false;
  const Eigen::VectorXd lift = slow_world_force(problem, without.residual).col(2);
  const Eigen::VectorXd law =
      slow_world_force(problem, contribution_of(problem, fit, fit.effects.size() - 1)).col(2);
  std::vector<double> both, own;
  double all_both = 0, all_own = 0;
  for (const auto& [begin, end] : passes) {
    both.push_back(lift.segment(begin, end - begin).dot(law.segment(begin, end - begin)));
    own.push_back(law.segment(begin, end - begin).squaredNorm());
    all_both += both.back();
    all_own += own.back();
  }
  double before = 0, after = 0;
  for (std::size_t k = 0; k < passes.size(); ++k) {
    const double others = all_own - own[k];
    if (!(others > 0)) return false;
    const auto [begin, end] = passes[k];
    const double strength = (all_both - both[k]) / others;
    before += lift.segment(begin, end - begin).squaredNorm();
    after += (lift.segment(begin, end - begin) - strength * law.segment(begin, end - begin)).squaredNorm();
  }
  return after < 0.5 * before && std::sqrt(all_own / problem.samples()) > o.min_magnitude * problem.scale(2);
}

void add_ground_law(const Problem& problem, double per_parameter, const Options& o, Naming& naming) {
  const physics::Effect* effect = physics::find_effect("ground_effect");
  for (const physics::ActiveEffect& e : naming.model.effects)
    if (e.effect == effect) return;
  const Fit base = fit_effects(problem, naming.model.effects, o);
  const Fit with = fit_with(problem, base, *effect, o);
  const double gain = with.log_likelihood - base.log_likelihood;
  if (gain < per_parameter || at_limit(problem, with.effects.back())) return;
  naming.null_model = fit_effects(problem, {}, o);
  naming.model = with;
  Named named;
  named.probability = 0.9;  // of the passes, half the force may be something else
  named.gain = gain;
  named.gate = gate_effect(problem, with, with.effects.size() - 1, o);
  naming.named.push_back(named);
}

}  // namespace omniflight::diagnosis
