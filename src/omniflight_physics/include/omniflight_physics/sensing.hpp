// How the sensors differ from ideal ones that sit in the body origin and know the time.
#pragma once

#include <limits>

#include "omniflight_core/frames.hpp"

namespace omniflight::physics {

/// Effects change it before a flight (Effect::alter_sensing); the sensors carry it out. The default is an
/// ideal sensor: every alteration is absent. Order of the inertial path: lever arm, structural mode,
/// vibration, misalignment and scale, bias, filter, stale samples.
struct Sensing {
  Vec3 imu_lever_arm = Vec3::Zero();               ///< m, sensor in the body: f + dw x r + w x (w x r)
  double mode_frequency = 20;                      ///< Hz, structural mode between body and inertial sensor
  double mode_damping = 0.05;                      ///< 1
  double mode_participation = 0;                   ///< 1, y + p (G y - y), G = wn^2/(s^2 + 2 z wn s + wn^2)
  double imbalance = 0;                            ///< m, m_b e / m: acceleration Omega^2 in each rotor plane
  double rectification = 0;                        ///< s^2/m, bias along body z per squared vibration
  Vec3 accelerometer_bias = Vec3::Zero();          ///< m/s^2
  Vec3 accelerometer_scale = Vec3::Zero();         ///< 1
  Vec3 accelerometer_misalignment = Vec3::Zero();  ///< rad, f + d x f
  Vec3 gyro_bias = Vec3::Zero();                   ///< rad/s
  Vec3 gyro_scale = Vec3::Zero();                  ///< 1
  double gyro_filter_time = 0;                     ///< s, 1/(2 pi f_c) of a second-order low-pass; 0 = none
  double accelerometer_filter_time = 0;            ///< s
  double filter_damping = 0.7071067811865476;      ///< 1, of both filters

  Vec3 mocap_tilt = Vec3::Zero();          ///< rad, rotation vector measured <- true world
  Vec3 mocap_offset = Vec3::Zero();        ///< m, p + R d: the body of the capture system has another origin
  Vec3 mocap_misalignment = Vec3::Zero();  ///< rad, R exp(d): and other axes
  double mocap_clock_offset = 0;           ///< s, a pose stamped t is that of (1 + skew) t + offset
  double mocap_clock_skew = 0;             ///< 1

  double stale_mocap = 0;  ///< probability that a pose repeats the one before under a new stamp
  double stale_imu = 0;    ///< probability that an inertial sample repeats the one before

  int rotor_fault = -1;          ///< index of the rotor whose speed sensor is faulty, -1 = none
  double rotor_fault_scale = 0;  ///< 1, reported = (1 + scale) speed + bias
  double rotor_fault_bias = 0;   ///< rad/s
  double rotor_fault_freeze =
      std::numeric_limits<double>::infinity();  ///< s, stuck at its value from then on

  double voltage_bias = 0;   ///< V
  double voltage_scale = 0;  ///< 1
  double current_scale = 0;  ///< 1
  /// The battery itself, beyond what the sensor model assumes: as in Actuation.
  double battery_resistance = 0;  ///< ohm
  double battery_drop = 0;        ///< V/J

  friend bool operator==(const Sensing&, const Sensing&) = default;
};

}  // namespace omniflight::physics
