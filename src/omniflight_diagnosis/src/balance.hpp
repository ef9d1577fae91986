// What the motors alone tell: in steady flight their torques must balance. For recordings without attitude or
// force, where no wrench can be computed.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Whether the baseline flights have steady parts enough for their scatter to be known; no baseline is fine.
Status check_baseline(const vehicle::Vehicle& vehicle, const Options& options);

/// A rotor that needs clearly more command than its share (rotor_thrust_scale), or a centre of mass beside
/// the middle (com_offset), told apart by the pattern over roll, pitch and yaw, against the differences that
/// the motors of one kind have anyway (Tolerance::motor_lateral, motor_yaw). Several flights count by how
/// long they were steady, each at its own tilt of the rotors; with Options::baseline the measure is their
/// mean and scatter instead. One that never was is left out, and said to be.
/// Errors: bad_input without motor signals or when none was steady for two seconds.
Result<Diagnosis> diagnose_balance(std::span<const recording::Recording> flown,
                                   const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
