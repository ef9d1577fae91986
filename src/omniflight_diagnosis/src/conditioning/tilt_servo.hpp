// Tilt angle of the rotors: measured, or by the servo model of the vehicle file.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Longest gap between commands that is interpolated [s], and least range of a command that shows a lag
/// [rad]. Chosen.
inline constexpr double kLongestTiltHold = 0.1, kLeastTiltMove = 0.02;

/// Response [rad] of the servo at times t [s] to the input [rad], starting at rest at the first finite input.
/// The input is interpolated linearly; where it is not finite the state is held and the response is NaN.
Eigen::VectorXd answer_of_servo(const vehicle::Tilt& servo, const std::vector<double>& t,
                                const Eigen::VectorXd& input);

/// Whether the recorded 'alpha' is a measurement behind the servo. False where it is an echo of the command:
/// nearer to the command without lag and play of the vehicle file than with them. True where the file has
/// neither, or where the command does not move enough to decide.
bool shows_told_servo(const recording::Recording& recording, const vehicle::Tilt& servo);

struct RotorTilt {
  recording::Signal alpha;  ///< rad
  bool modelled = false;    ///< alpha is the response of the servo model
};

/// The measured tilt angle, or the response of the servo model to 'alpha' (an echo of the command) or
/// 'alpha_command'. Empty when neither is recorded.
std::optional<RotorTilt> rotor_tilt(const recording::Recording& recording, const vehicle::Vehicle& vehicle);

/// rotor_tilt() at the times t [s], n x 1 [rad]; empty when unknown.
Eigen::MatrixXd tilt_at(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                        const std::vector<double>& t);

}  // namespace omniflight::diagnosis
