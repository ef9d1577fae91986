#include "scaled_matrix.hpp"

#include <algorithm>

namespace omniflight::allocation {

Eigen::MatrixXd scaled_matrix(const vehicle::Vehicle& v, double alpha) {
  Eigen::MatrixXd B = v.allocation_matrix(alpha);
  double lever = 0;
  for (Eigen::Index i = 0; i < B.cols(); ++i) {
    const Vec3 force = B.block<3, 1>(0, i);
    B.block<3, 1>(3, i) -= v.center_of_mass.cross(force);
    lever = std::max(lever, B.block<3, 1>(3, i).norm());
  }
  if (lever > 0) B.bottomRows<3>() /= lever;
  return B;
}

}  // namespace omniflight::allocation
