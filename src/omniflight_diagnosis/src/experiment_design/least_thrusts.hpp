// Minimum-norm control allocation.
#pragma once

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Pseudoinverse of the allocation matrix of a vehicle at rotor tilt alpha [rad]. A class of its own so that
/// the decomposition is compiled once.
class LeastThrusts {
 public:
  LeastThrusts(const vehicle::Vehicle& vehicle, double alpha);

  /// Minimum-norm thrusts [N], one per rotor, for a wrench [N, Nm] in body axes about the body origin;
  /// least-squares where it is not attainable. Thrust limits are ignored.
  vehicle::RotorVector operator()(const Vec6& wrench) const { return inverse_ * wrench; }

  int rank() const { return rank_; }  ///< of the allocation matrix; 6: fully actuated

 private:
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::ColMajor, vehicle::kMaxRotors, 6> inverse_;
  int rank_ = 0;
};

}  // namespace omniflight::diagnosis
