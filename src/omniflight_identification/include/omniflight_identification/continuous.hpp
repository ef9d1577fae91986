// A sampled model in continuous time.
#pragma once

#include "omniflight_identification/polynomial_model.hpp"

namespace omniflight::identification {

struct ContinuousEquivalent {
  double gain = 0.0;     ///< unit of y per unit of u, at rest
  double lag_s = 0.0;    ///< s
  double delay_s = 0.0;  ///< s, at least 0
};

/// The first-order lag with delay whose step response meets the model's at 28.3 % and 63.2 % of its end
/// (Smith's two points): lag = 1.5 (t63 - t28), delay = t63 - lag. Errors: unstable, no gain, or a response
/// that has not settled after 20000 samples.
Result<ContinuousEquivalent> continuous_equivalent(const PolynomialModel& model, Eigen::Index input);

/// Poles of the sampled model as rates log(p) / T [1/s]; real part -1 / lag.
std::vector<std::complex<double>> continuous_poles(const PolynomialModel& model);

}  // namespace omniflight::identification
