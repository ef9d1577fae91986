// Redundancy checks: measurements against commands, and against other sensors of the same quantity.
#pragma once

#include "kinematics.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Adds, with mismatches: actuator_saturation and thrust_dead_zone (limits of the rotors), battery_sag (all
/// rotors slower than commanded, or speed dependent on voltage at equal duty cycle), rotor_speed_sensor_fault
/// (one rotor deviates), tilt_servo_lag, command_quantisation and gyro_error (bias against the attitude).
/// Means over blocks of 3 s are the observations, and their scatter gives the standard errors. Checks whose
/// signals are missing, or whose effect is already among the findings of `diagnosis`, are skipped.
void check_redundancy(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                      const Options& options, Diagnosis& diagnosis);

/// Adds the parts of `kinematics` as findings: accelerometer_error, mocap_tilt, mocap_offset, imu_lever_arm.
void add_kinematics(const Kinematics& kinematics, Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
