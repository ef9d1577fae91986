// Regression of a vehicle's motion on what its rotors do, each axis by itself.
#pragma once

#include <span>
#include <vector>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Share of the variance of one axis at least that rotors must explain before anything is read out of how the
/// motion follows them. Chosen: below, noise of the speeds or disturbances prevail, and whatever smooths or
/// what feedback does fits better.
inline constexpr double kLeastByRotors = 0.85;

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

/// Columns through a first-order lag of this time [s] that begins at rest.
Eigen::MatrixXd lagged(const Eigen::MatrixXd& x, double time_s, double rate_hz);

/// Each axis of the angular acceleration and of the specific force as the rotor wrench and the torque of
/// spinning up along it, with free coefficients, so that mass and inertia need not be known. All of it above
/// 4 Hz: at lower frequency aerodynamic wrenches are not negligible.
class RotorRegression {
 public:
  /// Angular acceleration (n x 3, rad/s^2) and specific force (n x 3, m/s^2; 0 rows without an
  /// accelerometer); only samples with `use` set.
  RotorRegression(const Eigen::MatrixXd& dw, const Eigen::MatrixXd& force, const RotorExcitation& rotors,
                  double rate_hz, const std::vector<char>& use);

  bool enough() const;                                         ///< 3 s of samples
  int reach() const { return reach_; }                         ///< samples, the largest shift
  int axes() const { return static_cast<int>(axes_.size()); }  ///< the first three turn the vehicle
  double rate_hz() const { return rate_hz_; }
  double independent_samples() const;

  /// Share of the variance of an axis that the rotor wrench leaves when it comes `shift` samples late; 1
  /// where its coefficient is not positive.
  double left_at_once(int axis, int shift) const;
  /// Negative log-likelihood of a sample of the turning with torques that act at once, `shift` samples late.
  double misfit(int shift) const;
  /// The shift [samples] at which torques that act at once explain most of the turning.
  int best_shift() const { return best_shift_; }
  /// Whether rotors come after the turning by more than their clock (one standard deviation `clock_s`) can be
  /// off: they answer to disturbances, and how they follow the motion tells nothing of how it follows them.
  bool is_feedback(double clock_s) const { return -best_shift_ > 3 * clock_s * rate_hz_; }
  const Eigen::VectorXd& wrench(int axis) const { return axes_[static_cast<std::size_t>(axis)].wrench; }
  /// The same for T + lead (T - settled) of each lead, with T = wrench(axis) and what it settles to.
  std::vector<double> left(int axis, const Eigen::VectorXd& settled, int shift,
                           std::span<const double> leads) const;

 private:
  struct Axis {
    Eigen::VectorXd motion, wrench, spin_up;
  };
  double rate_hz_;
  int reach_, best_shift_ = 0;
  std::vector<int> rows_;
  std::vector<Axis> axes_;
  Eigen::MatrixXd at_once_;  ///< axes x shifts
};

}  // namespace omniflight::diagnosis
