// Where a flight touches the ground: standing, take-off, landing, crash.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

struct Ground {
  bool known = false;                  ///< it was seen standing
  double height = 0;                   ///< m, world height of the body's frame then
  std::vector<char> resting, crashed;  ///< a sample
};

/// How far below a standing vehicle the floor is unless something says better [radii of its rotors].
constexpr double kLeastHubHeight = 0.3;

/// m, mean of the rotors.
double mean_radius(const vehicle::Vehicle& vehicle);

/// Thrust of all rotors at sample i, as if they pushed the same way [N].
double push_at(const Eigen::MatrixXd& rotor_speed, Eigen::Index i, const vehicle::Vehicle& vehicle);

/// All matrices have one row a sample of a uniform grid: position [m], rotor speed [rad/s], tilt (one column)
/// [rad], specific force [m/s^2, body], attitude (w, x, y, z). Standing: nothing moves for 0.3 s and the
/// rotors carry less than 85 % of the weight, or they carry less than 30 % at the lowest place; up to a
/// centimetre above that height it still stands. Crash: a shock beyond 5 g after which the rotors stop, or a
/// turn past 100 deg (of a vehicle that cannot fly so) after which it is not carried upright again within 3
/// s.
Ground find_ground(const Eigen::MatrixXd& position, bool has_position, const Eigen::MatrixXd& rotor_speed,
                   const Eigen::MatrixXd& specific_force, const Eigen::MatrixXd& attitude, double rate_hz,
                   const vehicle::Vehicle& vehicle, const Options& options);

/// Factor on a modelled thrust with which the rotors carry the vehicle in free flight (median of mass times
/// specific force over the force of all rotors; away from the lowest tenth of its heights).
double lift_scale(const Eigen::MatrixXd& rotor_speed, const Eigen::MatrixXd& alpha,
                  const Eigen::MatrixXd& specific_force, const Eigen::MatrixXd& position, bool has_position,
                  const vehicle::Vehicle& vehicle);

}  // namespace omniflight::diagnosis
