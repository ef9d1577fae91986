// Recordings computed from the physics library: a fully actuated vehicle that climbs, pauses and sidesteps.
#pragma once

#include <gtest/gtest.h>

#include "omniflight_physics/effect.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis::test {

/// The shipped vehicle.
vehicle::Vehicle omnimorph();

struct Flown {
  double duration_s = 30, rate_hz = 100;
  double climb_m = 0.7, side_m = 0.3;  ///< climb in two steps with pauses, sidesteps in between
  double alpha = 0.5;                  ///< rad
  double sway = 0.0;                   ///< rad, amplitude of roll and pitch
  bool wanders = false;                ///< sways at five frequencies, as a pilot does, and not at one
  double force_noise_N = 0.15, torque_noise_Nm = 0.01, correlation_s = 0.3;  ///< coloured disturbance
  double answer_s =
      0;  ///< the rotors cancel the disturbance after this lag, as feedback makes them; 0: they do not
  /// The rotors give the torque with which the rate forgets its disturbance. Without, it is a drag about
  /// every axis that nobody flew, small beside what is usually hidden.
  bool damped = true;
  double accelerometer_noise = 0.05, gyro_noise = 0.005, speed_noise = 0.5;  ///< m/s^2, rad/s, rad/s
  std::uint64_t seed = 1;
  double swing = 0;  ///< rad, by which loads already swing along x when the recording begins
};

/// Position [m] and attitude at time t [s] of a flight.
Vec3 path(double t, const Flown& f);
Quat attitude(double t, const Flown& f);

/// The recording of a flight in a world with these effects.
recording::Recording fly(const vehicle::Vehicle& vehicle, const std::vector<physics::ActiveEffect>& effects,
                         const Flown& f);

/// Duty cycles in place of the rotor speeds: `full` at the largest speed of the vehicle file.
void drive_by_duty(recording::Recording& recording, const vehicle::Vehicle& vehicle, double full);

/// Rotor speeds [rad/s, 5000 samples x rotors] that jitter about hover, by 30 % and below 20 Hz.
Eigen::MatrixXd jittering_speeds(const vehicle::Vehicle& v, double rate_hz);

}  // namespace omniflight::diagnosis::test
