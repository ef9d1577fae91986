// Likelihood of measured rotor speeds given the commands and a set of drive effects.
#pragma once

#include <limits>
#include <vector>

#include "drive_record.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_physics/prior.hpp"

namespace omniflight::diagnosis {

/// A set of drive effects with values. Standardised coordinates, prior N(0, 1): ln(lag / lag of the vehicle
/// file), offset between time stamps of commands and speeds, then the parameters of the members in order. A
/// parameter with a half-normal prior uses the magnitude of its coordinate.
struct DriveSet {
  std::vector<const physics::Effect*> members;
  Eigen::VectorXd coordinates = Eigen::VectorXd::Zero(2);

  /// Physical parameters of a member, in its units.
  std::vector<double> theta(std::size_t member, const physics::VehicleSize& size) const;
  /// Index of a member's first coordinate.
  Eigen::Index first(std::size_t member) const;
};

/// Measured speed = gain (with linear drift) times the speed simulated by physics::Actuators, plus a
/// constant, plus an error. Gain and constant (supply, telemetry scale) are free per rotor; the redundancy
/// checks judge them. The error follows Student's t distribution: a command may move between its samples, and
/// where a rotor reverses its speed moves far in that time. Its squared scale is that of the residual, plus
/// the law error (0.3 Options::law_error times the RMS of speed minus command)^2, plus (0.1 % of the
/// speed)^2. The likelihood counts independent samples only.
class DriveModel {
 public:
  /// `stamps_s` [s]: prior standard deviation of the offset between time stamps.
  DriveModel(const vehicle::Vehicle& vehicle, std::vector<DriveRecord> records, Between between,
             double stamps_s, const Options& options);
  /// The model restricted to one rotor of each motor controller and the first `seconds`, for fast scans.
  DriveModel part(double seconds) const;

  /// -ln(likelihood times prior density) [nat] up to constants; infinite for invalid drives.
  double cost(const DriveSet& set) const;
  /// Sets the numbers of independent samples from the autocorrelation of the residual of this set.
  void count_samples(const DriveSet& set);

  /// RMS residual [rad/s] over all rotors.
  double rms_left(const DriveSet& set) const;
  double samples() const;  ///< independent samples of all rotors
  /// Offset between time stamps [s]; positive: commands act later.
  double offset_s(const DriveSet& set) const { return stamps_s_ * set.coordinates[1]; }
  const physics::VehicleSize& size() const { return size_; }

 private:
  struct Rest;  ///< comparison of one rotor in one record
  /// One Rest per record and rotor; with `left`, also residuals. False for invalid drives.
  bool simulate(const DriveSet& set, std::vector<Rest>& out, bool left) const;
  Rest compare(const DriveRecord& record, Eigen::Index rotor, const Eigen::MatrixXd& ends, bool left) const;

  vehicle::Vehicle vehicle_;
  physics::VehicleSize size_;
  std::vector<DriveRecord> records_;
  Between between_;
  double stamps_s_, law_error_, freedom_, temperature_;
  std::vector<double> independent_;  ///< independent samples per record and rotor
};

}  // namespace omniflight::diagnosis
