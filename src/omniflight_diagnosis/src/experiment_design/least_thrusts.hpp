// The smallest rotor thrusts that give a wrench.
#pragma once

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Of a vehicle at one tilt, by the pseudoinverse of its allocation matrix. A class of its own so that the
/// decomposition is compiled once.
class LeastThrusts {
 public:
  LeastThrusts(const vehicle::Vehicle& vehicle, double alpha);

  /// N, one a rotor, without regard to their limits, of least squares where the rotors cannot give the wrench
  /// [N, Nm], in body axes about the body origin.
  vehicle::RotorVector operator()(const Vec6& wrench) const { return inverse_ * wrench; }

  int rank() const { return rank_; }  ///< 6: every wrench

 private:
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::ColMajor, vehicle::kMaxRotors, 6> inverse_;
  int rank_ = 0;
};

}  // namespace omniflight::diagnosis
