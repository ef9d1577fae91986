#include "least_thrusts.hpp"

namespace omniflight::diagnosis {

LeastThrusts::LeastThrusts(const vehicle::Vehicle& vehicle, double alpha) {
  const Eigen::MatrixXd allocation = vehicle.allocation_matrix(alpha);
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factor(allocation);
  rank_ = static_cast<int>(factor.rank());
  inverse_ = factor.pseudoInverse();
}

}  // namespace omniflight::diagnosis
