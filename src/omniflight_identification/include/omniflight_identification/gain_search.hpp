// The next gains to fly, from those that were flown and how they did.
#pragma once

#include <optional>
#include <vector>

#include "omniflight_identification/pidn.hpp"

namespace omniflight::identification {

struct FlownGains {
  PidnGains gains;
  double score = 0.0;  ///< mean speed error [rad/s], less is better
};

struct SearchOptions {
  double step = 1.5;             ///< factor by which a gain is first changed
  double finest = 1.05;          ///< the search has settled when smaller factors would be next
  double max_sensitivity = 2.0;  ///< gains beyond it are not proposed, whatever they might score
  double control_period_s = 0.001;
};

/// Pattern search about the best gains flown so far (Hooke and Jeeves 1961): kp, ki and kd one after the
/// other are multiplied and divided by the step; when all of that was flown and nothing was better, the step
/// becomes its square root. It needs no state but the list of flights, so that it can go on after any break.
/// Nothing when it has settled. Errors: an empty list, gains that are not finite, plants that tune_pidn()
/// refuses.
Result<std::optional<PidnGains>> next_gains(const std::vector<FlownGains>& flown,
                                            const std::vector<LagPlant>& plants,
                                            const SearchOptions& options = {});

}  // namespace omniflight::identification
