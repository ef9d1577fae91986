// The likelihood of recorded rotor speeds, given their commands and what alters the drives between the two.
#pragma once

#include <limits>
#include <vector>

#include "drive_record.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_physics/prior.hpp"

namespace omniflight::diagnosis {

/// Effects that act between command and speed, at values. Coordinates of an inference, in this order: the
/// logarithm of the drives' lag over what the vehicle file tells, the offset between the stamps of commands
/// and of speeds, then the members' parameters; all N(0, 1) before the flight. A parameter of one sign is
/// that of the coordinate's size.
struct DriveSet {
  std::vector<const physics::Effect*> members;
  Eigen::VectorXd coordinates = Eigen::VectorXd::Zero(2);

  /// Parameters of a member.
  std::vector<double> theta(std::size_t member, const physics::VehicleSize& size) const;
  /// Index of a member's first coordinate.
  Eigen::Index first(std::size_t member) const;
};

/// Speeds are those of physics::Actuators, the drives that the simulator flies, times a gain that drifts,
/// plus a constant (a supply, a telemetry; other checks judge them), plus an error: noise, and what the law
/// of the drives has wrong, an RMS of Options::law_error of how far they keep a speed from its command. Both
/// have the same unknown course, so that samples count as far as they are independent.
class DriveModel {
 public:
  /// `stamps_s`: one standard deviation of the offset between the stamps.
  DriveModel(const vehicle::Vehicle& vehicle, std::vector<DriveRecord> records, Between between,
             double stamps_s, const Options& options);
  /// One rotor of each board during `seconds`, which is enough to see where to begin.
  DriveModel part(double seconds) const;

  /// Minus the logarithm of likelihood times prior density, up to constants; infinite for drives that cannot
  /// be.
  double cost(const DriveSet& set) const;
  /// Counts samples by the correlation of what this set leaves.
  void count_samples(const DriveSet& set);

  /// RMS [rad/s] of what it leaves, over all rotors.
  double rms_left(const DriveSet& set) const;
  double samples() const;  ///< that are independent, all rotors
  double offset_s(const DriveSet& set) const { return stamps_s_ * set.coordinates[1]; }
  const physics::VehicleSize& size() const { return size_; }

 private:
  struct Rest;  ///< of one rotor in one record
  /// False for drives that cannot be. `left`: residuals, where asked for.
  bool simulate(const DriveSet& set, std::vector<Rest>& out, bool left) const;
  Rest compare(const DriveRecord& record, Eigen::Index rotor, const Eigen::MatrixXd& ends, bool left) const;

  vehicle::Vehicle vehicle_;
  physics::VehicleSize size_;
  std::vector<DriveRecord> records_;
  Between between_;
  double stamps_s_, law_error_, temperature_;
  std::vector<double> independent_;  ///< samples, a rotor and record
};

}  // namespace omniflight::diagnosis
