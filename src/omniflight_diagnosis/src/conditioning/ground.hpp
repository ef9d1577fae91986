// Where a flight touches the ground: standing, take-off, landing, crash.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

struct Ground {
  bool known = false;                  ///< the vehicle was seen standing
  double height = 0;                   ///< m, world height of the body origin while standing
  std::vector<char> resting, crashed;  ///< flag per sample
};

/// Default height of the rotor hubs above the floor while standing [rotor radii]; chosen. The ground effect,
/// where identifiable, replaces it (search/floor_height).
constexpr double kLeastHubHeight = 0.3;

/// Mean rotor radius [m].
double mean_radius(const vehicle::Vehicle& vehicle);

/// Sum of the magnitudes of all nominal thrusts at sample i [N].
double push_at(const Eigen::MatrixXd& rotor_speed, Eigen::Index i, const vehicle::Vehicle& vehicle);

/// Detects standing and crashes. One row per sample of a uniform grid: position [m, world], rotor speed
/// [rad/s], specific force [m/s^2, body], attitude (w, x, y, z). All thresholds are chosen. Standing:
/// position constant within 4 mm for 0.3 s with thrust below 85 % of the weight, or thrust below 30 % within
/// 2 cm of the lowest height; then up to 1 cm above the resting height with thrust below 90 %. Crash:
/// specific force above 5 g after which the rotors stop, or inclination beyond 100 deg (of a vehicle that
/// cannot fly inverted) without upright, carried flight again within 3 s.
Ground find_ground(const Eigen::MatrixXd& position, bool has_position, const Eigen::MatrixXd& rotor_speed,
                   const Eigen::MatrixXd& specific_force, const Eigen::MatrixXd& attitude, double rate_hz,
                   const vehicle::Vehicle& vehicle, const Options& options);

/// Scale of a modelled thrust: median over free flight of mass times |specific force| over |sum of thrusts|,
/// without the lowest tenth of the heights (ground effect). alpha [rad], one column; other matrices as
/// find_ground().
double lift_scale(const Eigen::MatrixXd& rotor_speed, const Eigen::MatrixXd& alpha,
                  const Eigen::MatrixXd& specific_force, const Eigen::MatrixXd& position, bool has_position,
                  const vehicle::Vehicle& vehicle);

}  // namespace omniflight::diagnosis
