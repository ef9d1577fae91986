#include "omniflight_identification/residual_tests.hpp"

#include <cmath>

namespace omniflight::identification {
namespace {

constexpr double kLevel = 0.01;

/// Counted residuals and inputs of every experiment.
struct Rest {
  Eigen::VectorXd e, u;
};
std::vector<Rest> rests(const PolynomialModel& model, const Dataset& data, Eigen::Index input,
                        Eigen::Index skip) {
  std::vector<Rest> out;
  for (const Experiment& x : data.experiments) {
    const Eigen::Index n = x.y.size() - skip;
    if (n < 1) continue;
    Rest r{residuals(model, x).tail(n), Eigen::VectorXd::Zero(n)};
    if (input >= 0) r.u = x.u.col(input).tail(n);
    r.e.array() -= r.e.mean();
    r.u.array() -= r.u.mean();
    out.push_back(std::move(r));
  }
  return out;
}

double lagged_product(const Eigen::VectorXd& later, const Eigen::VectorXd& earlier, Eigen::Index lag) {
  const Eigen::Index n = later.size() - lag;
  return n > 0 ? later.tail(n).dot(earlier.head(n)) : 0.0;
}

}  // namespace

Eigen::VectorXd autocorrelation(const Eigen::VectorXd& x, int lags) {
  Eigen::VectorXd r = Eigen::VectorXd::Zero(lags + 1);
  if (x.size() == 0) return r;
  const Eigen::VectorXd centred = x.array() - x.mean();
  const double power = centred.squaredNorm();
  if (!(power > 0)) return r;
  for (int k = 0; k <= lags; ++k) r[k] = lagged_product(centred, centred, k) / power;
  return r;
}

double chi_squared_tail(double x, double dof) {
  if (!(x > 0)) return 1.0;
  const double spread = 2.0 / (9.0 * dof);
  return 0.5 * std::erfc((std::cbrt(x / dof) - (1.0 - spread)) / std::sqrt(2.0 * spread));
}

ResidualTest whiteness(const PolynomialModel& model, const Dataset& data, const FitOptions& options,
                       int lags) {
  ResidualTest test;
  Eigen::VectorXd products = Eigen::VectorXd::Zero(lags + 1);
  double n = 0;
  for (const Rest& r : rests(model, data, -1, options.transient_samples)) {
    for (int k = 0; k <= lags; ++k) products[k] += lagged_product(r.e, r.e, k);
    n += static_cast<double>(r.e.size());
  }
  test.correlation = products.tail(lags) / std::max(products[0], 1e-300);
  test.bound = kTwoSided99 / std::sqrt(std::max(n, 1.0));
  test.statistic = n * test.correlation.squaredNorm();
  test.p_value = chi_squared_tail(test.statistic, lags);
  test.passed = test.p_value >= kLevel;
  return test;
}

namespace {

/// Residuals against the input 0, 1, ... samples before, or with `later` 1, 2, ... samples after.
ResidualTest cross_correlation(const PolynomialModel& model, const Dataset& data, Eigen::Index input,
                               const FitOptions& options, int lags, bool later) {
  ResidualTest test;
  const auto all = rests(model, data, input, options.transient_samples);
  // correlations reach as far as the variance of their sum needs: both series' products die out by then
  const int reach = static_cast<int>(std::max<Eigen::Index>(4 * lags, 2 * options.transient_samples));
  Eigen::VectorXd ee = Eigen::VectorXd::Zero(reach + 1), uu = ee, eu = Eigen::VectorXd::Zero(lags);
  double n = 0;
  for (const Rest& r : all) {
    for (int k = 0; k <= reach; ++k) {
      ee[k] += lagged_product(r.e, r.e, k);
      uu[k] += lagged_product(r.u, r.u, k);
    }
    for (int k = 0; k < lags; ++k)
      eu[k] += later ? lagged_product(r.u, r.e, k + 1) : lagged_product(r.e, r.u, k);
    n += static_cast<double>(r.e.size());
  }
  n = std::max(n, 1.0);
  ee /= n, uu /= n, eu /= n;
  // covariance of sqrt(n) eu(k) and eu(l): sum over tau of ee(tau) uu(tau + k - l) (Ljung 1999, eq. 16.66)
  const auto at = [&](const Eigen::VectorXd& x, int k) {
    return std::abs(k) <= reach ? x[std::abs(k)] : 0.0;
  };
  Eigen::VectorXd covariance = Eigen::VectorXd::Zero(lags);
  for (int k = 0; k < lags; ++k)
    for (int tau = -reach; tau <= reach; ++tau)
      covariance[k] += (1.0 - std::abs(tau) / (reach + 1.0)) * at(ee, tau) * at(uu, tau + k);
  Eigen::MatrixXd P(lags, lags);
  for (int k = 0; k < lags; ++k)
    for (int l = 0; l < lags; ++l) P(k, l) = covariance[std::abs(k - l)];
  const double scale = std::sqrt(std::max(ee[0] * uu[0], 1e-300));
  test.correlation = eu / scale;
  test.bound = kTwoSided99 * std::sqrt(std::max(covariance[0], 0.0) / n) / scale;
  // an input that is held or smooth leaves directions without power: they tell nothing and are left out
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(P);
  int directions = 0;
  for (int k = 0; k < lags; ++k) {
    const double variance = eigen.eigenvalues()[k];
    if (!(variance > 1e-3 * eigen.eigenvalues()[lags - 1])) continue;
    const double along = eigen.eigenvectors().col(k).dot(eu);
    test.statistic += n * along * along / variance;
    ++directions;
  }
  test.p_value = chi_squared_tail(test.statistic, std::max(directions, 1));
  test.passed = test.p_value >= kLevel;
  return test;
}

}  // namespace

ResidualTest independence(const PolynomialModel& model, const Dataset& data, Eigen::Index input,
                          const FitOptions& options, int lags) {
  return cross_correlation(model, data, input, options, lags, false);
}

ResidualTest feedback(const PolynomialModel& model, const Dataset& data, Eigen::Index input,
                      const FitOptions& options, int lags) {
  return cross_correlation(model, data, input, options, lags, true);
}

}  // namespace omniflight::identification
