// Whether rotors may be started: what must be there before, named when it is not. Pure.
#pragma once

#include <cstdint>
#include <omniflight_core/result.hpp>
#include <optional>

namespace omniflight::safety {

struct PreflightLimits {
  bool recorder = true;                    ///< a recorder must be there
  std::uint64_t free_bytes = 100'000'000;  ///< on its disk: ten minutes of flight
  double pose_age_s = 0.5;                 ///< s, of the newest pose
  double battery_V = 0.0;                  ///< V, least; 0 = not judged
  double missed_share = 1.0;  ///< most of the periods that the gateway's own clock may miss; 1 = not judged
};

/// What is found before the start.
struct Readiness {
  std::size_t commanders = 0;    ///< publishers of rotor commands
  std::size_t pose_sources = 0;  ///< publishers of poses
  bool recorder = false;
  std::optional<std::uint64_t> free_bytes;  ///< on the recorder's disk, when it is known
  std::optional<double> pose_age_s;         ///< s; empty: none has come
  std::optional<double> battery_V;
  std::optional<double>
      missed_share;  ///< of the gateway's periods while it waits; empty: not observed for long enough
};

/// Ok, or everything that is missing in one error.
Status preflight(const PreflightLimits& limits, const Readiness& found);

}  // namespace omniflight::safety
