#include "omniflight_identification/gain_search.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::identification {
namespace {

constexpr double kSame = 0.01;  // gains that differ by less count as flown

bool same(double a, double b) { return std::abs(a - b) <= kSame * std::max(std::abs(a), std::abs(b)); }

bool was_flown(const PidnGains& gains, const std::vector<FlownGains>& flown) {
  return std::any_of(flown.begin(), flown.end(), [&](const FlownGains& f) {
    return same(f.gains.kp, gains.kp) && same(f.gains.ki, gains.ki) && same(f.gains.kd, gains.kd);
  });
}

bool robust(const PidnGains& gains, const std::vector<LagPlant>& plants, const SearchOptions& options) {
  return std::all_of(plants.begin(), plants.end(), [&](const LagPlant& p) {
    const Margins m = margins(gains, p, options.control_period_s);
    return m.stable && m.max_sensitivity <= options.max_sensitivity;
  });
}

}  // namespace

Result<std::optional<PidnGains>> next_gains(const std::vector<FlownGains>& flown,
                                            const std::vector<LagPlant>& plants,
                                            const SearchOptions& options) {
  if (flown.empty()) return bad_input("no gains were flown yet", "runs", "Fly those of tune-motor first");
  for (const FlownGains& f : flown)
    if (!std::isfinite(f.gains.kp + f.gains.ki + f.gains.kd + f.score))
      return bad_input("a run has gains or a score that are no numbers", "runs",
                       "Give --gains to compare-runs");
  if (!(options.step > options.finest && options.finest > 1))
    return bad_input("must be above the finest factor, and that above 1", "step");
  if (auto ok = check(plants, {.control_period_s = options.control_period_s}); !ok)
    return Failure(ok.error());
  const PidnGains best = std::min_element(flown.begin(), flown.end(), [](const auto& a, const auto& b) {
                           return a.score < b.score;
                         })->gains;
  for (double step = options.step; step >= options.finest; step = std::sqrt(step))
    for (double PidnGains::*gain : {&PidnGains::kp, &PidnGains::ki, &PidnGains::kd})
      for (const double factor : {step, 1.0 / step}) {
        PidnGains tried = best;
        tried.*gain *= factor;
        if (!was_flown(tried, flown) && robust(tried, plants, options))
          return std::optional<PidnGains>(tried);
      }
  return std::optional<PidnGains>();
}

}  // namespace omniflight::identification
