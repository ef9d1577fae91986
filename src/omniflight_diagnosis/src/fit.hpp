// Generalised least squares for a set of effects: parameters within bounds, offsets with priors, whitening
// refitted with every set.
#pragma once

#include "whitening.hpp"

namespace omniflight::diagnosis {

struct Fit {
  std::vector<physics::ActiveEffect> effects;
  Eigen::VectorXd offsets;    ///< in units of Problem::offset_names
  Eigen::VectorXd residual;   ///< rows, what remains
  double log_likelihood = 0;  ///< with the prior of the offsets
  std::vector<std::pair<double, double>>
      plausible;       ///< a parameter: values met within 1.92 of the best likelihood
  int parameters = 0;  ///< free parameters of the effects
  Eigen::VectorXd se;  ///< of the parameters in order, where by_instruments() found them; else empty
};

/// Bends a law instead of scaling it: it has no value at which the effect is nothing.
inline bool is_shape(const physics::Parameter& p) { return !p.linear && p.typical == p.neutral; }

/// An amplitude stands at the end of what makes sense: then it is not this effect that the flight shows.
bool at_limit(const Problem& problem, const physics::ActiveEffect& effect);

/// Starts from the given parameter values (linear parameters need no good start).
Fit fit_effects(const Problem& problem, const std::vector<physics::ActiveEffect>& start,
                const Options& options);

/// As fit_effects with one more effect, whose shape parameters are searched over their bounds first.
Fit fit_with(const Problem& problem, const Fit& base, const physics::Effect& effect, const Options& options);

/// Final values: offsets that would compete with the named effects are held near zero (their tolerance stays
/// in the standard errors), so that the effects alone, as a model file lists them, predict best.
Fit settle(const Problem& problem, const Fit& fit, const Options& options);
/// The standard deviations of the offsets that settle() holds them near zero by.
Eigen::VectorXd settled_offsets(const Problem& problem, const Fit& fit);

/// A cheap preview of fit_with: one Gauss-Newton step from the shape parameters in `hint` (searched on a grid
/// when there is none). Its likelihood ranks candidates.
Fit quick_with(const Problem& problem, const Fit& base, const physics::Effect& effect, const Options& options,
               const std::vector<double>* hint = nullptr);

/// Restarts every shape parameter from values around its own: a bend in a law makes local minima. Fills
/// plausible.
Fit profile_shapes(const Problem& problem, const Fit& fit, const Options& options);

/// Standard errors of all effect parameters, in order: the larger of GLS and a block-robust estimate.
Eigen::VectorXd standard_errors(const Problem& problem, const Fit& fit, const Options& options);

/// For every effect, how far all its numbers together are from nothing, as a normal score (Wald test; bends
/// of laws do not count). Where only a product is known, as of wind and drag, no number alone is away from
/// nothing.
std::vector<double> distances_from_nothing(const Problem& problem, const Fit& fit, const Options& options);

/// Mean gain per block, in units of its standard error, that effect `index` brings on blocks its coefficients
/// were not fitted to; and the share of whitened residual energy it removes in its best channel.
struct Gate {
  double gain = 0;  ///< log-likelihood it brings when the noise is fitted to what the full model leaves
  double cross_validated_se = 0;
  double energy_share = 0;  ///< whitened or raw, the larger: a slow effect is small after whitening
  double magnitude = 0;     ///< RMS of its contribution over weight, or over weight times arm
};
Gate gate_effect(const Problem& problem, const Fit& full, std::size_t index, const Options& options);

/// What effect `index` takes out of the residual.
Eigen::VectorXd contribution_of(const Problem& problem, const Fit& fit, std::size_t index);

/// Stacked Jacobian of all effect parameters at a fit, then the offsets.
Eigen::MatrixXd jacobian_of(const Problem& problem, const Fit& fit);

}  // namespace omniflight::diagnosis
