// Lag between rotor speeds and gyro from the rotational dynamics: angular acceleration follows torque without
// delay.
#pragma once

#include <optional>

#include "rotor_regression.hpp"

namespace omniflight::diagnosis {

/// Lag of the gyro behind the rotor speeds: delay of the gyro filter minus that of the rotor telemetry. It is
/// the shift at which nominal rotor torque and spin-up torque best explain the high-passed angular
/// acceleration, each with a free coefficient per axis, so that inertias need not be known.
struct TorqueLag {
  double lag_s = 0, se_s = 0;  ///< estimate and standard error
  double explained = 0;        ///< coefficient of determination of the best axis
};

/// Empty below 3 s of samples, at the edge of the search, or where the torques explain less than 85 % on
/// every axis: rotors then answer to external disturbances, and the lag would be that of the controller.
std::optional<TorqueLag> lag_behind_rotors(const RotorRegression& regression);

/// x delayed by lag_s [s] by linear interpolation; the end rows are held.
Eigen::MatrixXd delayed(const Eigen::MatrixXd& x, double lag_s, double rate_hz);

}  // namespace omniflight::diagnosis
