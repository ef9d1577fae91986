// How well a flight followed its reference, from a Recording of whatever origin.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::report {

/// A vehicle this far [m] from its reference has left it.
inline constexpr double kLeftReference = 0.5;
/// ... and so has one whose attitude is this far off [deg, RMSE].
inline constexpr double kTurnedAway = 45.0;

struct Tracking {
  Vec3 position_rmse = Vec3::Zero();  ///< m, world x y z
  Vec3 attitude_rmse = Vec3::Zero();  ///< deg, about body x y z (roll, pitch, yaw for small errors)
  double worst_position = 0;          ///< m, largest position error
  double worst_position_at = 0;       ///< s
  double worst_attitude = 0;          ///< deg, largest angle to the reference
  double worst_attitude_at = 0;       ///< s
  std::optional<double> left_at;      ///< s, when the position error first exceeded kLeftReference
  std::vector<double> t;              ///< s
  Eigen::MatrixXd error;              ///< rows: samples; m (3), deg (3)
};

struct FlightMetrics {
  double from = 0, to = 0;  ///< s, from the first to the last motion of the reference
  bool has_truth = false;
  Tracking measured;                  ///< motion capture (or the estimate) against the reference
  Tracking truth;                     ///< simulation only: the true pose against the reference
  double mean_power = 0;              ///< W, mechanical, from rotor speeds; 0 when there are none
  double thesis_power = 0;            ///< "W" of the thesis: c_tau [Nm/Hz^2] times speed [Hz]^3
  Vec6 mean_integral = Vec6::Zero();  ///< m/s^2, rad/s^2, integral action
  Vec6 rms_integral = Vec6::Zero();   ///< likewise
  bool has_integral = false;
};

/// Mechanical power [W] at every sample of the measured rotor speeds; empty when there are none.
struct PowerCurve {
  std::vector<double> t;  ///< s
  std::vector<double> W;
};
PowerCurve mechanical_power(const recording::Recording& recording, const vehicle::Vehicle& vehicle);

/// Refuses a recording without reference or pose.
Result<FlightMetrics> assess(const recording::Recording& recording, const vehicle::Vehicle& vehicle);

/// One figure of two flights side by side, as in Table 7.1 of the OmniMorph thesis.
struct ComparedRow {
  std::string channel, unit;
  double simulated = 0, real = 0;
  double ratio() const { return simulated != 0 ? real / simulated : 0.0; }  ///< 0 where there is none
};
/// RMSE of position [m] and attitude [deg] as measured in both, mean power [W], and the integral action.
std::vector<ComparedRow> compare(const FlightMetrics& simulated, const FlightMetrics& real);

}  // namespace omniflight::report
