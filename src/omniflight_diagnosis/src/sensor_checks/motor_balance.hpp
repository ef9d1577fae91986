// Balance of the motors: in steady flight their torques must cancel. For recordings without attitude or
// acceleration, where no wrench residual exists.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Distribution of the imbalance of a sound vehicle: torque about roll, pitch and yaw over weight times mean
/// lever.
struct Yardstick {
  Vec3 expected = Vec3::Zero(), sigma;  ///< mean and standard deviation
  int flights = 0;                      ///< baseline flights they come from; 0: from Tolerance

  /// -2 ln likelihood of an imbalance up to a constant: normal, or Student's t with baseline flights.
  double chi(const Vec3& imbalance) const;
};

/// From Options::baseline, or without one from Tolerance::motor_lateral and motor_yaw, the differences
/// between motors of one type. Errors: bad_input when fewer than three baseline flights have steady parts.
Result<Yardstick> balance_yardstick(const vehicle::Vehicle& vehicle, const Options& options);

/// Detects a rotor that needs more command than its share (rotor_thrust_scale) or an offset of the centre of
/// mass (com_offset), distinguished by the ratio of roll, pitch and yaw imbalance. Flights are weighted by
/// their steady duration, each at its own rotor tilt; those without steady flight are listed in left_out.
/// Thresholds on the difference of chi are chosen: 5.3 for a rotor, 6.8 for the centre of mass. Errors:
/// bad_input without motor signals, or when no flight was steady for two seconds.
Result<Diagnosis> diagnose_balance(std::span<const recording::Recording> flown,
                                   const vehicle::Vehicle& vehicle, const Yardstick& yardstick);

}  // namespace omniflight::diagnosis
