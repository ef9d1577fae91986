// What the motors alone tell: in steady flight their torques must balance. For recordings without attitude or
// force, where no wrench can be computed.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// The imbalance over roll, pitch and yaw (torque over weight times mean arm) of a sound vehicle, and how far
/// one is from that by chance.
struct Yardstick {
  Vec3 expected = Vec3::Zero(), sigma;
  int flights = 0;  ///< baseline flights that it was taken from; 0: tolerance of the vehicle

  /// Minus twice the log-likelihood of an imbalance, a constant apart: normal, or Student's t where the
  /// standard deviations come from few flights.
  double chi(const Vec3& imbalance) const;
};

/// From Options::baseline, or Tolerance::motor_lateral and motor_yaw where there is none: the differences
/// that motors of one kind have anyway. Errors: bad_input when fewer than three baseline flights have steady
/// parts.
Result<Yardstick> balance_yardstick(const vehicle::Vehicle& vehicle, const Options& options);

/// A rotor that needs clearly more command than its share (rotor_thrust_scale), or a centre of mass beside
/// the middle (com_offset), told apart by the pattern over roll, pitch and yaw. Several flights count by how
/// long they were steady, each at its own tilt of the rotors; one that never was is left out, and said to be.
/// Errors: bad_input without motor signals or when none was steady for two seconds.
Result<Diagnosis> diagnose_balance(std::span<const recording::Recording> flown,
                                   const vehicle::Vehicle& vehicle, const Yardstick& yardstick);

}  // namespace omniflight::diagnosis
