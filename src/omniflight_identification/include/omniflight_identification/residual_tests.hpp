// Whether a model has taken everything out of the data: tests of its residuals (Ljung 1999, section 16.6).
#pragma once

#include "omniflight_identification/fit.hpp"

namespace omniflight::identification {

/// 99 % of a normal distribution lie within so many standard deviations
inline constexpr double kTwoSided99 = 2.5758;

/// Autocorrelation of x at lags 0..lags, 1 at lag 0; zeros when x does not move.
Eigen::VectorXd autocorrelation(const Eigen::VectorXd& x, int lags);
/// P(chi-squared with `dof` degrees of freedom > x), by Wilson and Hilferty (1931): good to 0.002.
double chi_squared_tail(double x, double dof);

struct ResidualTest {
  Eigen::VectorXd correlation;  ///< at lags 1.. (whiteness) or 0.. (independence), over all experiments
  double bound = 0.0;           ///< 99 % of a single correlation when the hypothesis holds
  double statistic = 0.0;       ///< chi-squared distributed when it holds
  double p_value = 0.0;
  bool passed = false;  ///< p_value >= 0.01
};

/// Residuals against their own past: sum of N r(k)^2 over lags 1..lags.
ResidualTest whiteness(const PolynomialModel& model, const Dataset& data, const FitOptions& options,
                       int lags = 25);
/// Residuals against past values of an input; the correlations' covariance takes the input's and the
/// residuals' own correlation into account. A fault here is a fault of the plant's model, whatever the noise
/// is.
ResidualTest independence(const PolynomialModel& model, const Dataset& data, Eigen::Index input,
                          const FitOptions& options, int lags = 25);
/// The same against later values of the input, u(t + 1).., which only a loop that is closed correlates with
/// residuals.
ResidualTest feedback(const PolynomialModel& model, const Dataset& data, Eigen::Index input,
                      const FitOptions& options, int lags = 25);

}  // namespace omniflight::identification
