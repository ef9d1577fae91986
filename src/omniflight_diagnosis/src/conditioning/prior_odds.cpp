#include "prior_odds.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_physics/prior.hpp"

namespace omniflight::diagnosis {
namespace {

/// Expected number of unknown errors of sensors, motors and control in a recording. Chosen; half or double
/// shifts all log odds by ln 2.
constexpr double kExpectedEffects = 0.35;

}  // namespace

double log_odds_beside_wrench(const physics::EffectInfo& info) {
  const auto& effects = physics::builtin_effects();
  const auto count = std::count_if(effects.begin(), effects.end(), [](const physics::Effect* e) {
    return e->info().stage != physics::Stage::wrench;
  });
  return std::log(kExpectedEffects * physics::occurrence(info) /
                  static_cast<double>(std::max<std::ptrdiff_t>(1, count)));
}

}  // namespace omniflight::diagnosis
