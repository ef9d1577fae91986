#include "linear_prediction.hpp"

#include <Eigen/Cholesky>

namespace omniflight::diagnosis {

Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets) {
  constexpr double kRidge = 1e-6;  // of the variance: collinear regressors stay solvable
  const Eigen::RowVectorXd mean = known.colwise().mean(), target_mean = targets.colwise().mean();
  Eigen::MatrixXd X = known.rowwise() - mean;
  const Eigen::MatrixXd Y = targets.rowwise() - target_mean;
  const auto n = static_cast<double>(X.rows());
  for (Eigen::Index k = 0; k < X.cols(); ++k) {
    const double deviation = std::sqrt(X.col(k).squaredNorm() / n);
    X.col(k) *= deviation > 0 ? 1 / deviation : 0.0;
  }
  Eigen::MatrixXd H = X.transpose() * X;
  H.diagonal().array() += kRidge * n;
  return (X * H.llt().solve(X.transpose() * Y)).rowwise() + target_mean;
}

}  // namespace omniflight::diagnosis
