#pragma once

#include <Eigen/Dense>

namespace omniflight::identification {

/// Covariance of least-squares parameters from residuals e and their gradient J (a row a sample), with the
/// correlation of e over `window` samples (Newey and West 1987); window 0 allows for unequal variances alone.
Eigen::MatrixXd robust_covariance(const Eigen::MatrixXd& J, const Eigen::VectorXd& e, Eigen::Index window);
/// (J'J)^-1, with columns scaled to one and directions that nothing excites left out.
Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& J);
/// The window that grows with the cube root of n, times `factor`, at most a quarter of n.
Eigen::Index correlation_window(Eigen::Index n, double factor);

}  // namespace omniflight::identification
