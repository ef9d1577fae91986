// Clock alignment between two signals by cross-correlation.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

struct LagOptions {
  double max_lag_s = 0.3;  ///< lags up to this, both ways, are tried
  double from_s = -1e18;   ///< window on the clock of `a`
  double to_s = 1e18;
  bool same_sign = false;  ///< only where both rise together: half a period later is no lag
};

struct LagEstimate {
  double lag_s = 0.0;             ///< b(t) = gain * a(t - lag): positive when b comes later
  double standard_error_s = 0.0;  ///< one sigma, with the residual's own correlation time taken into account
  double correlation = 0.0;       ///< at the best lag, in [-1, 1]
  double gain = 0.0;              ///< least-squares scale from a to b
  double rival = 0.0;             ///< correlation at the best lag beyond this peak, 0 where there is none
};

/// Lag of b behind a; both need the same width (components are used together). Errors: fewer than 50 common
/// samples, no variation, or the best lag lies at the edge of the search.
Result<LagEstimate> estimate_lag(const Signal& a, const Signal& b, const LagOptions& options = {});

}  // namespace omniflight::recording
