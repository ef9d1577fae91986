// Whether thrust follows the speeds of the rotors at once.
#pragma once

#include <optional>

#include "torque_alignment.hpp"

namespace omniflight::diagnosis {

/// T + lead (T - T_settled), where T_settled follows T = k_f Omega^2 with a time constant: -1 is thrust that
/// comes late, above 0 it overshoots until the air follows (dynamic inflow).
struct ThrustResponse {
  double time = 0, time_se = 0;  ///< s
  double lead = 0;               ///< 1
  double log_factor = 0;         ///< nat, against speeds whose clock is off by any time within kReach
};

/// From angular acceleration (n x 3, rad/s^2) and specific force (n x 3, m/s^2; 0 rows without an
/// accelerometer) at samples with `use` set; each axis has a free coefficient, so that mass and inertia need
/// not be known. `clock_s` [s]: one standard deviation of the clock of the speeds. Empty below 3 s of
/// samples, where thrust explains less than 85 % on every axis (what smooths noisy speeds fits better), or
/// where no response is likelier than a clock.
std::optional<ThrustResponse> thrust_response(const Eigen::MatrixXd& dw, const Eigen::MatrixXd& force,
                                              const RotorExcitation& rotors, double rate_hz, double clock_s,
                                              const std::vector<char>& use);

/// Speeds [rad/s, n x rotors] whose squares respond like that.
Eigen::MatrixXd responding(const Eigen::MatrixXd& speed, const ThrustResponse& response, double rate_hz);

}  // namespace omniflight::diagnosis
