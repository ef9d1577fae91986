// Clocks of rotor speeds and gyroscope, told by the motion: the body turns when the rotors push, not later.
#pragma once

#include <optional>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// How much later the gyroscope tells of a turn than the rotor speeds of its cause [s]: its filter, less what
/// the telemetry of the rotors loses. The shift under which torques of the rotors and their spin-up explain
/// the quick part of the angular acceleration best, each with a scale of its own, so that no coefficient
/// needs to be known.
struct TorqueLag {
  double lag_s = 0, se_s = 0;
  double explained = 0;  ///< share of the angular acceleration's variance, of the axis where it is largest
};

/// dw [rad/s^2], speed and turning [rad/s] on one grid, a row a sample; speed is what thrust follows (root of
/// filtered squares), turning what momentum follows (filtered as it is); alpha [rad]; only samples with
/// `use` count. Nothing where they explain less than 85 % of every axis: what
/// pushes from outside is answered by the rotors later, and would pass for a clock.
std::optional<TorqueLag> lag_behind_rotors(const Eigen::MatrixXd& dw, const Eigen::MatrixXd& speed,
                                           const Eigen::MatrixXd& turning, const Eigen::MatrixXd& alpha,
                                           double rate_hz, const std::vector<char>& use,
                                           const vehicle::Vehicle& vehicle);

/// x as it was `lag_s` before; the first and last rows are held.
Eigen::MatrixXd delayed(const Eigen::MatrixXd& x, double lag_s, double rate_hz);

}  // namespace omniflight::diagnosis
