#include "omniflight_safety/preflight.hpp"

#include <cmath>
#include <string>

namespace omniflight::safety {

Status preflight(const PreflightLimits& limits, const Readiness& found) {
  std::string missing;
  const auto need = [&missing](bool there, const std::string& what) {
    if (!there) missing += (missing.empty() ? "" : "; ") + what;
  };
  const auto one = [&need](std::size_t n, const std::string& what) {
    need(n == 1, n == 0 ? "nobody publishes " + what
                        : std::to_string(n) + " publishers of " + what + ", must be one");
  };
  one(found.commanders, "rotor commands");
  one(found.pose_sources, "poses");
  need(!limits.recorder || found.recorder, "no recorder");
  need(!limits.recorder || !found.free_bytes || *found.free_bytes >= limits.free_bytes,
       std::to_string(found.free_bytes.value_or(0) / 1'000'000) +
           " MB left on the recorder's disk, at least " + std::to_string(limits.free_bytes / 1'000'000) +
           " MB are needed");
  need(found.pose_age_s && *found.pose_age_s <= limits.pose_age_s,
       found.pose_age_s ? "newest pose is " + std::to_string(*found.pose_age_s) + " s old"
                        : "no pose has come");
  need(limits.battery_V <= 0 || (found.battery_V && *found.battery_V >= limits.battery_V),
       found.battery_V ? "battery at " + std::to_string(*found.battery_V) + " V, at least " +
                             std::to_string(limits.battery_V) + " V are needed"
                       : "battery voltage unknown");
  need(limits.missed_share >= 1 || (found.missed_share && *found.missed_share <= limits.missed_share),
       found.missed_share
           ? std::to_string(100 * *found.missed_share) + " % of the periods missed while waiting, at most " +
                 std::to_string(100 * limits.missed_share) + " % are allowed"
           : "the clock has not been observed for long enough");
  if (missing.empty()) return {};
  return fail(ErrorCode::incomplete, "rotors are not started: " + missing, "preflight",
              "Mend it and start again");
}

}  // namespace omniflight::safety
