#include "other_stages.hpp"

#include <algorithm>
#include <cmath>

#include "../conditioning/prior_odds.hpp"
#include "../numerics/log_factor.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "omniflight_physics/prior.hpp"

namespace omniflight::diagnosis {
namespace {

/// See judge_sizes(). A parameter that the library does not list has a prior as wide as its estimate.
double probability_of(const Finding& f, const physics::VehicleSize& size) {
  const physics::Effect* effect = physics::find_effect(f.effect);
  if (!effect) return std::nan("");
  const bool judged = f.parameters.empty() || f.log_factor != 0;
  double log_factor = judged ? f.log_factor : -1e300;
  for (const ParameterValue& p : f.parameters) {
    if (judged) break;
    const double error = (p.high - p.low) / (2 * 1.96);
    const auto& all = effect->info().parameters;
    const auto at = std::find_if(all.begin(), all.end(), [&](const auto& x) { return x.name == p.name; });
    if (!(error > 0)) continue;
    const auto k = static_cast<std::size_t>(at - all.begin());
    const double neutral = at == all.end() ? 0 : at->neutral;
    const double deviation =
        at == all.end() ? std::max(std::abs(p.value), error) : physics::prior_of(*effect, k, size).slope(0);
    log_factor = std::max(log_factor, log_factor_of_size(p.value - neutral, error, deviation));
  }
  return 1 / (1 + std::exp(-(log_factor + log_odds_beside_wrench(effect->info())))) / (1 + f.rivals);
}

}  // namespace

std::vector<const Flight*> with_honest_speeds(const std::vector<Flight>& flights) {
  std::vector<const Flight*> out;
  for (const Flight& f : flights)
    if (std::none_of(f.faults.begin(), f.faults.end(), [](const SensorFault& fault) {
          return fault.effect == physics::effect_id::rotor_speed_sensor_fault;
        }))
      out.push_back(&f);
  return out;
}

void judge_sizes(const vehicle::Vehicle& vehicle, const Options& o, std::vector<Finding>& findings) {
  const physics::VehicleSize size = physics::size_of(vehicle, o.environment.gravity);
  for (Finding& f : findings) f.probability = probability_of(f, size);
}

void add_judged(const Diagnosis& others, const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  std::vector<Finding> findings = others.findings;
  judge_sizes(vehicle, o, findings);
  d.decisions.insert(d.decisions.end(), others.decisions.begin(), others.decisions.end());
  bool any = false;
  for (Finding& f : findings) {
    const bool kept = f.probability * (1 + f.rivals) >= 0.5;  // it, or one of its rivals
    d.decisions.push_back({f.effect, "size of what a stage beside the wrench shows", f.probability, 0.5,
                           "normal likelihood against the prior of its size", kept ? "kept" : "refused"});
    if (!kept) continue;
    any = true;
    for (const physics::ActiveEffect& m : others.model)
      if (m.effect->info().id == f.effect) d.model.push_back(m);
    d.findings.push_back(std::move(f));
  }
  if (any) d.mismatch.insert(d.mismatch.end(), others.mismatch.begin(), others.mismatch.end());
  d.controller = others.controller;
  if (any && d.verdict == Verdict::nothing_missing) d.verdict = Verdict::explained;
}

}  // namespace omniflight::diagnosis
