// Lag between rotor speeds and gyro from the rotational dynamics: angular acceleration follows torque without
// delay.
#pragma once

#include <optional>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

// Chosen, not measured.
inline constexpr double kReach = 0.024;       ///< s, half width of the search; gyro filters delay by less
inline constexpr double kCorrelation = 0.05;  ///< s, correlation time of the misfit, for standard errors

/// Nominal wrench of the rotors; samples x 3, body.
struct RotorExcitation {
  Eigen::MatrixXd force, torque;  ///< N, Nm
  Eigen::MatrixXd spin_up;        ///< rad/s^2, sum of spin times acceleration along the axes
};

/// At speed and turning (n x rotors, rad/s; FineMotion::rotor_speed and rotor_turning) and alpha (n x 1,
/// rad).
RotorExcitation rotor_excitation(const Eigen::MatrixXd& speed, const Eigen::MatrixXd& turning,
                                 const Eigen::MatrixXd& alpha, double rate_hz,
                                 const vehicle::Vehicle& vehicle);

/// Columns less what a low pass leaves of them: at low frequency aerodynamic wrenches are not negligible.
Eigen::MatrixXd quick_part(const Eigen::MatrixXd& x, double rate_hz);

/// Lag of the gyro behind the rotor speeds: delay of the gyro filter minus that of the rotor telemetry. It is
/// the shift at which nominal rotor torque and spin-up torque best explain the high-passed angular
/// acceleration, each with a free coefficient per axis, so that inertias need not be known.
struct TorqueLag {
  double lag_s = 0, se_s = 0;  ///< estimate and standard error
  double explained = 0;        ///< coefficient of determination of the best axis
};

/// Estimates the lag from dw (n x 3, rad/s^2); only samples with `use` set. Empty below 3 s of samples, at
/// the edge of the search, or where the torques explain less than 85 % on every axis: rotors then answer to
/// external disturbances, and the lag would be that of the controller.
std::optional<TorqueLag> lag_behind_rotors(const Eigen::MatrixXd& dw, const RotorExcitation& rotors,
                                           double rate_hz, const std::vector<char>& use);

/// x delayed by lag_s [s] by linear interpolation; the end rows are held.
Eigen::MatrixXd delayed(const Eigen::MatrixXd& x, double lag_s, double rate_hz);

}  // namespace omniflight::diagnosis
