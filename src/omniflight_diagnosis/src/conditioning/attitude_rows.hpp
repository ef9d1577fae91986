// Attitudes as they come out of a recording: rows of quaternions (w, x, y, z), world <- body.
#pragma once

#include <Eigen/Dense>

#include "omniflight_core/frames.hpp"

namespace omniflight::diagnosis {

/// Attitude of row i, normalised.
inline Quat quaternion(const Eigen::MatrixXd& q, Eigen::Index i) {
  return Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)).normalized();
}

/// Flips signs so that adjacent rows lie in one hemisphere: q and -q are the same attitude, but averaging
/// them is not.
void make_continuous(Eigen::MatrixXd& q);

/// Rotates rows (n x 3) from world to body axes, and back.
void turn_into_body(const Eigen::MatrixXd& q, Eigen::MatrixXd& x);
void turn_into_world(const Eigen::MatrixXd& q, Eigen::MatrixXd& x);

/// Body rate w_WB_B [rad/s], n x 3, by central differences; zero at both ends.
Eigen::MatrixXd rate_from_attitude(const Eigen::MatrixXd& q, double rate_hz);

}  // namespace omniflight::diagnosis
