// Polynomials in the delay operator as filters, and their roots.
#include <Eigen/Eigenvalues>

#include "omniflight_identification/polynomial_model.hpp"

namespace omniflight::identification {

Eigen::VectorXd monic(const Eigen::VectorXd& coefficients) {
  Eigen::VectorXd out(coefficients.size() + 1);
  out << 1.0, coefficients;
  return out;
}

Eigen::VectorXd filtered(const Eigen::VectorXd& numerator, const Eigen::VectorXd& denominator,
                         const Eigen::VectorXd& x) {
  Eigen::VectorXd y(x.size());
  const Eigen::Index nb = numerator.size(), na = denominator.size();
  for (Eigen::Index t = 0; t < x.size(); ++t) {
    double sum = 0;
    for (Eigen::Index k = 0; k < std::min(nb, t + 1); ++k) sum += numerator[k] * x[t - k];
    for (Eigen::Index k = 1; k < std::min(na, t + 1); ++k) sum -= denominator[k] * y[t - k];
    y[t] = sum;
  }
  return y;
}

bool schur_stable(const Eigen::VectorXd& coefficients) {
  Eigen::VectorXd p = monic(coefficients);
  for (Eigen::Index n = p.size() - 1; n > 0; --n) {
    const double reflection = p[n];
    if (!(std::abs(reflection) < 1.0)) return false;
    const Eigen::VectorXd reversed = p.head(n + 1).reverse();
    p = ((p.head(n + 1) - reflection * reversed) / (1.0 - reflection * reflection)).head(n).eval();
  }
  return true;
}

std::vector<std::complex<double>> roots(const Eigen::VectorXd& coefficients) {
  const Eigen::Index n = coefficients.size();
  if (n == 0) return {};
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  companion.row(0) = -coefficients.transpose();
  companion.bottomLeftCorner(n - 1, n - 1).setIdentity();
  const Eigen::VectorXcd values = companion.eigenvalues();
  return {values.data(), values.data() + n};
}

Eigen::VectorXd stabilised(const Eigen::VectorXd& coefficients) {
  if (coefficients.size() == 0 || !coefficients.allFinite())
    return Eigen::VectorXd::Zero(coefficients.size());
  constexpr double kLargest = 1.0 - 1e-3;
  Eigen::VectorXcd polynomial = Eigen::VectorXcd::Ones(1);
  for (std::complex<double> root : roots(coefficients)) {
    if (std::abs(root) > 1.0) root = 1.0 / std::conj(root);
    if (std::abs(root) > kLargest) root *= kLargest / std::abs(root);
    Eigen::VectorXcd next = Eigen::VectorXcd::Zero(polynomial.size() + 1);
    next.head(polynomial.size()) = polynomial;
    next.tail(polynomial.size()) -= root * polynomial;
    polynomial = next;
  }
  return polynomial.tail(polynomial.size() - 1).real();
}

}  // namespace omniflight::identification
