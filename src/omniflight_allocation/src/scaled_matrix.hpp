// The allocation matrix in numbers of one size.
#pragma once

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

/// Force and torque per newton of thrust at tilt alpha [rad] (6 x rotors), torques about the centre of mass
/// and divided by the longest lever arm [m].
Eigen::MatrixXd scaled_matrix(const vehicle::Vehicle& vehicle, double alpha);

}  // namespace omniflight::allocation
