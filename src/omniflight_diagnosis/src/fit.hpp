// Generalised least squares for a set of effects: parameters within bounds, offsets with priors, whitening
// refitted with every set.
#pragma once

#include <limits>

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

/// As fit_effects with one more effect, whose shape parameters are searched over their bounds first. Ends
/// early where steps as long as the last one would not reach the log-likelihood `least`.
Fit fit_with(const Problem& problem, const Fit& base, const physics::Effect& effect, const Options& options,
             double least = -std::numeric_limits<double>::infinity());

/// The same, its bends searched over a grid only, one after another: several times quicker, and enough to say
/// whether a law comes near. Given bends of much the same flight, on the part of the grid around them.
Fit fit_on_grid(const Problem& problem, const Fit& base, const physics::Effect& effect,
                const Options& options, const std::vector<double>* found = nullptr);

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

/// What effect `index` takes out of the residual.
Eigen::VectorXd contribution_of(const Problem& problem, const Fit& fit, std::size_t index);

/// Stacked Jacobian of all effect parameters at a fit, then the offsets.
Eigen::MatrixXd jacobian_of(const Problem& problem, const Fit& fit);

}  // namespace omniflight::diagnosis
