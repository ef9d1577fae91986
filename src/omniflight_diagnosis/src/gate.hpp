// Whether an effect of a fit would stand on data that it was not fitted to.
#pragma once

#include "fit.hpp"

namespace omniflight::diagnosis {

/// RMS over the natural size of a channel below which nothing is said: filters, grid and derivatives leave
/// 1.5e-5 of a flight that is exact.
constexpr double kAccuracy = 5e-5;
/// The same for a term that is called unknown: who says that something is in no library has looked at more
/// than what a known effect needs.
constexpr double kLeastUnknown = 4 * kAccuracy;

/// Mean gain per block, in units of its standard error, that effect `index` brings on blocks its coefficients
/// were not fitted to; and the share of whitened residual energy it removes in its best channel of its best
/// flight.
struct Gate {
  double gain = 0;  ///< log-likelihood it brings when the noise is fitted to what the full model leaves
  double cross_validated_se = 0;
  double energy_share = 0;  ///< whitened or raw, the larger: a slow effect is small after whitening
  double prominence = 0;  ///< share of raw energy it removes in its best channel of its best flight while all
                          ///< else stays as it is
  double magnitude = 0;   ///< RMS of its contribution over weight, or over weight times arm
  double removed = 0;     ///< RMS that it takes out of the residual beside everything else, in the same unit
};
Gate gate_effect(const Problem& problem, const Fit& full, std::size_t index, const Options& options);

}  // namespace omniflight::diagnosis
