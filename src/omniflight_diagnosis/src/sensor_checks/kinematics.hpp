// What the accelerometer says of the motion against what motion capture says of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_diagnosis/options.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Chance that what is told of a sensor reaches as far as what is found of it: rarer is a finding.
constexpr double kBeyondTold = 5e-4;

/// Errors of an accelerometer and of the frame of motion capture. Neither air nor turbulence plays a part:
/// every force moves the position and the accelerometer alike. For a smooth window phi of time,
///   int phi'' p_m dt = int phi (R f_m + g) dt - int phi R b dt - int phi'' R r dt + d x g
/// with bias b [m/s^2, body], lever arm r of the IMU [m, body] and tilt d of the measured world [rad, world].
struct Kinematics {
  struct Part {
    std::string effect;                ///< accelerometer_error, mocap_tilt or imu_lever_arm
    Eigen::VectorXd value, se;         ///< in the units of the effect's parameters
    std::vector<std::string> as_well;  ///< effects that explain the same windows as well
  };
  std::vector<Part> parts;  ///< those that are needed, the strongest first
  int windows = 0;

  const Part* find(const std::string& effect) const;
};

/// Nothing where position, attitude or specific force is missing, or where they contradict each other so much
/// that they cannot belong to one body (a force in other axes, say).
std::optional<Kinematics> judge_kinematics(const recording::Recording& recording, const Options& options);

}  // namespace omniflight::diagnosis
