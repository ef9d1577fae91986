// What the motors alone tell: in steady flight their torques must balance. For recordings without attitude or
// force, where no wrench can be computed.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// True when the recording has motor signals but not what a wrench analysis needs.
bool only_motors(const recording::Recording& recording);

/// A rotor that needs clearly more command than its share (rotor_thrust_scale), or a centre of mass beside
/// the middle (com_offset), told apart by the pattern over roll, pitch and yaw, against the differences that
/// the motors of one kind have anyway (Tolerance::motor_lateral, motor_yaw).
/// Errors: bad_input without motor signals or with less than two seconds of steady flight.
Result<Diagnosis> diagnose_balance(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                                   const Options& options);

}  // namespace omniflight::diagnosis
