// Small numbers about samples.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace omniflight::diagnosis {

/// P(chi-squared with `dof` degrees of freedom > x).
double chi_squared_tail(double x, double dof);
/// x with chi_squared_tail(x, dof) = p, for 0 < p < 1.
double chi_squared_quantile(double p, double dof);

/// ln of the standard normal distribution function.
double log_normal_cdf(double x);
/// ln of its mass between two values.
double log_normal_between(double low, double high);

/// Share of the variance of y that X (with a constant added) explains, and the coefficients (constant last).
double explained_share(const Eigen::MatrixXd& X, const Eigen::VectorXd& y,
                       Eigen::VectorXd* coefficients = nullptr);

/// Sample below which `share` of the others are, without interpolation; 0 without samples.
double quantile(std::vector<double> x, double share);

/// The upper one of the two middle samples of an even number; 0 without samples.
double median(std::vector<double> x);

inline double rms(const Eigen::VectorXd& x) {
  return x.size() > 0 ? std::sqrt(x.squaredNorm() / static_cast<double>(x.size())) : 0.0;
}

}  // namespace omniflight::diagnosis
