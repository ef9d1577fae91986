// Consistency of accelerometer and motion capture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_diagnosis/options.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// False-alarm probability per recording of a sensor error within its told tolerance. Chosen: one in 2000.
constexpr double kBeyondTold = 5e-4;

/// Errors of the accelerometer and of the motion capture frame. Forces, turbulence among them, need no model,
/// since they act on position and accelerometer alike. For a smooth window phi(t),
///   int phi'' p_m dt = int phi (R f_m + g) dt - int phi R b dt - int phi'' R r dt + d x g
/// with measured position p_m and specific force f_m, bias b [m/s^2, body], lever arm r of the IMU [m, body]
/// and tilt d of the measured world [rad, world].
struct Kinematics {
  struct Part {
    std::string effect;                ///< accelerometer_error, mocap_tilt or imu_lever_arm
    Eigen::VectorXd value, se;         ///< estimate and standard error, as the parameters of the effect
    std::vector<std::string> as_well;  ///< rivals within 3 nat
  };
  std::vector<Part> parts;  ///< errors that were found, in order of selection
  int windows = 0;          ///< that were evaluated

  /// The part of this effect, or null.
  const Part* find(const std::string& effect) const;
};

/// Empty where position, attitude or specific force is missing, with fewer than 20 windows of 0.6 s, or where
/// the signals disagree by more than errors of this kind can explain (e.g. a specific force in other axes).
std::optional<Kinematics> judge_kinematics(const recording::Recording& recording, const Options& options);

}  // namespace omniflight::diagnosis
