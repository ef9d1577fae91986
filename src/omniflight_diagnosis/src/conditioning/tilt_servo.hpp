// Where the rotors stand, as far as the tilt servo of the vehicle file tells.
#pragma once

#include <optional>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// A command that is older than this is not known any more, and one that stays within this shows no lag.
inline constexpr double kLongestTiltHold = 0.1, kLeastTiltMove = 0.02;  // s, rad

/// Tilt [rad] that the servo gives at times t [s], starting at rest at the first input [rad]. The input is
/// taken straight between samples; where it is not finite, the servo waits and the answer is not finite.
Eigen::VectorXd answer_of_servo(const vehicle::Tilt& servo, const std::vector<double>& t,
                                const Eigen::VectorXd& input);

/// False when the recorded tilt angle is no measurement behind the servo but what the servo was set to: it
/// is nearer to its command without the lag and play that the vehicle file tells than with them. True where
/// nothing is told, or no command moves by which to tell.
bool shows_told_servo(const recording::Recording& recording, const vehicle::Tilt& servo);

struct RotorTilt {
  recording::Signal alpha;  ///< rad
  bool modelled = false;    ///< the servo of the vehicle file answers what is recorded
};

/// The measured tilt angle; where only what the servo was set to is recorded ('alpha' without the told lag,
/// or nothing but 'alpha_command'), the answer of the servo to it. Nothing when neither is recorded.
std::optional<RotorTilt> rotor_tilt(const recording::Recording& recording, const vehicle::Vehicle& vehicle);

/// It at these times [s], one row each; empty when it is not known.
Eigen::MatrixXd tilt_at(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                        const std::vector<double>& t);

}  // namespace omniflight::diagnosis
