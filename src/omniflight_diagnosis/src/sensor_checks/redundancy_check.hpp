// What was measured against what was ordered, and against what another sensor says of the same thing.
#pragma once

#include "kinematics.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Findings actuator_saturation and thrust_dead_zone (limits of the rotors), battery_sag (all rotors turn
/// slower than ordered, or their duty cycle sets a share of the voltage), rotor_speed_sensor_fault (one does,
/// by its own telemetry), tilt_servo_lag, command_quantisation and gyro_error (a bias against the measured
/// attitude), each with its mismatch. All are judged on means over blocks of some seconds, whose scatter
/// gives the standard errors. Signals that are missing are passed over.
void check_redundancy(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                      const Options& options, Diagnosis& diagnosis);

/// Findings accelerometer_error, mocap_tilt, mocap_offset and imu_lever_arm of what does not fit one motion.
void add_kinematics(const Kinematics& kinematics, Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
