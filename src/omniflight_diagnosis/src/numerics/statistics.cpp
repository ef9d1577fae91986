#include "statistics.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_core/frames.hpp"

namespace omniflight::diagnosis {

double chi_squared_tail(double x, double dof) {
  if (!(x > 0)) return 1.0;
  const double a = 0.5 * dof, z = 0.5 * x;
  const double front = std::exp(a * std::log(z) - z - std::lgamma(a));
  if (z < a + 1) {  // series of the lower tail
    double term = 1.0 / a, sum = term;
    for (int k = 1; k < 500; ++k) sum += term *= z / (a + k);
    return std::clamp(1.0 - front * sum, 0.0, 1.0);
  }
  double b = z + 1 - a, c = 1e300, d = 1.0 / b, h = d;  // continued fraction of the upper tail
  for (int k = 1; k < 500; ++k) {
    const double an = -k * (k - a);
    b += 2;
    d = an * d + b;
    if (std::abs(d) < 1e-300) d = 1e-300;
    c = b + an / c;
    if (std::abs(c) < 1e-300) c = 1e-300;
    d = 1.0 / d;
    const double change = d * c;
    h *= change;
    if (std::abs(change - 1) < 1e-12) break;
  }
  return std::clamp(front * h, 0.0, 1.0);
}

double chi_squared_quantile(double p, double dof) {
  double low = 0, high = dof + 10;
  while (chi_squared_tail(high, dof) > p && high < 1e6) high *= 2;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (chi_squared_tail(middle, dof) > p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// far below zero by its asymptotic series
double log_normal_cdf(double x) {
  if (x > -8) return std::log(0.5 * std::erfc(-x / std::sqrt(2.0)));
  return -0.5 * x * x - std::log(-x) - 0.5 * std::log(2 * kPi) + std::log1p(-1 / (x * x));
}

double log_normal_between(double low, double high) {
  if (low > 0) return log_normal_between(-high, -low);  // the tail that is not near one
  const double above = log_normal_cdf(high), below = log_normal_cdf(low);
  return above + std::log1p(-std::exp(std::min(below - above, -1e-15)));
}

double explained_share(const Eigen::MatrixXd& X, const Eigen::VectorXd& y, Eigen::VectorXd* coefficients) {
  Eigen::MatrixXd Z(X.rows(), X.cols() + 1);
  Z << X, Eigen::VectorXd::Ones(X.rows());
  const Eigen::VectorXd b = Z.colPivHouseholderQr().solve(y);
  if (coefficients) *coefficients = b;
  const double total = (y.array() - y.mean()).matrix().squaredNorm();
  return total > 0 ? std::clamp(1.0 - (y - Z * b).squaredNorm() / total, 0.0, 1.0) : 0.0;
}

double quantile(std::vector<double> x, double share) {
  if (x.empty()) return 0;
  const auto at = x.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(x.size() - 1));
  std::nth_element(x.begin(), at, x.end());
  return *at;
}

double median(std::vector<double> x) {
  if (x.empty()) return 0;
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

}  // namespace omniflight::diagnosis
