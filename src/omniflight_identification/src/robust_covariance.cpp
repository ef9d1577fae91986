#include "robust_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::identification {

Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& J) {
  const Eigen::VectorXd scale = J.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd columns = J * scale.asDiagonal();
  const Eigen::MatrixXd information = columns.transpose() * columns;
  return scale.asDiagonal() * information.completeOrthogonalDecomposition().pseudoInverse() *
         scale.asDiagonal();
}

Eigen::MatrixXd robust_covariance(const Eigen::MatrixXd& J, const Eigen::VectorXd& e, Eigen::Index window) {
  const Eigen::Index n = e.size();
  const Eigen::MatrixXd inverse = inverse_information(J), scores = e.asDiagonal() * J;
  Eigen::MatrixXd middle = scores.transpose() * scores;
  for (Eigen::Index k = 1; k <= window; ++k) {
    const double weight = 1.0 - static_cast<double>(k) / static_cast<double>(window + 1);
    const Eigen::MatrixXd cross = scores.bottomRows(n - k).transpose() * scores.topRows(n - k);
    middle += weight * (cross + cross.transpose());
  }
  return inverse * middle * inverse;
}

Eigen::Index correlation_window(Eigen::Index n, double factor) {
  return std::min(n / 4, static_cast<Eigen::Index>(factor * std::cbrt(static_cast<double>(n))));
}

}  // namespace omniflight::identification
