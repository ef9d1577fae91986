#include "other_stages.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_physics/effect_ids.hpp"
#include "omniflight_physics/prior.hpp"

namespace omniflight::diagnosis {
namespace {

/// Expected number of errors of sensors, motors and control that a laboratory does not know of.
constexpr double kExpected = 0.35;

double probability_of(const Finding& f, const physics::VehicleSize& size) {
  const physics::Effect* effect = physics::find_effect(f.effect);
  if (!effect) return f.probability;
  int count = 0;
  for (const physics::Effect* e : physics::builtin_effects())
    count += e->info().stage != physics::Stage::wrench;
  const double log_odds = std::log(kExpected * physics::occurrence(effect->info()) / std::max(1, count));
  double best = 0;
  for (const ParameterValue& p : f.parameters) {
    const double error = (p.high - p.low) / (2 * 1.96);
    const auto& all = effect->info().parameters;
    const auto at = std::find_if(all.begin(), all.end(), [&](const auto& x) { return x.name == p.name; });
    if (!(error > 0)) continue;
    const auto k = static_cast<std::size_t>(at - all.begin());
    const double neutral = at == all.end() ? 0 : at->neutral;
    const double deviation =
        at == all.end() ? std::max(std::abs(p.value), error) : physics::prior_of(*effect, k, size).slope(0);
    best = std::max(best, presence(p.value - neutral, error, deviation, log_odds));
  }
  // without a size: a sensor that repeats or holds its values, found by counting samples
  return f.parameters.empty() ? f.probability : best;
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

double presence(double estimate, double standard_error, double deviation, double log_odds) {
  const double s2 = standard_error * standard_error, d2 = deviation * deviation;
  const double log_factor = 0.5 * estimate * estimate / s2 * d2 / (s2 + d2) - 0.5 * std::log1p(d2 / s2);
  return 1 / (1 + std::exp(-(log_factor + log_odds)));
}

void add_judged(const Diagnosis& others, const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  const physics::VehicleSize size = physics::size_of(vehicle, o.environment.gravity);
  bool any = false;
  for (Finding f : others.findings) {
    f.probability = probability_of(f, size);
    const bool kept = f.probability >= 0.5;
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
