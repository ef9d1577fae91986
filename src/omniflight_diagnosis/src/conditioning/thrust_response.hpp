// Whether thrust follows the speeds of the rotors at once.
#pragma once

#include <optional>

#include "rotor_regression.hpp"

namespace omniflight::diagnosis {

/// T + lead (T - T_settled), where T_settled follows T = k_f Omega^2 with a time constant: -1 is thrust that
/// comes late, above 0 it overshoots until the air follows (dynamic inflow).
struct ThrustResponse {
  double time = 0, time_se = 0;  ///< s
  double lead = 0;               ///< 1
  double log_factor = 0;         ///< nat, against speeds whose clock is off by any time within the reach
};

/// `clock_s` [s]: one standard deviation of the clock of the speeds. Empty below 3 s of samples, where thrust
/// explains less than 85 % on every axis (what smooths noisy speeds fits better), or where no response is
/// likelier than a clock.
std::optional<ThrustResponse> thrust_response(const RotorRegression& regression, double clock_s);

/// Speeds [rad/s, n x rotors] whose squares respond like that.
Eigen::MatrixXd responding(const Eigen::MatrixXd& speed, const ThrustResponse& response, double rate_hz);

}  // namespace omniflight::diagnosis
