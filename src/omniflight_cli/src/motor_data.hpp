// Command and speed of one rotor out of a recording, on a uniform time base.
#pragma once

#include <string>

#include "omniflight_identification/data.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::cli {

/// What battery voltage is taken for.
enum class VoltageUse {
  none,          ///< not recorded, or told to be left out
  second_input,  ///< an input beside the command
  product        ///< scales the command: a duty cycle times the voltage is what reaches the motor
};
/// "not used", "second input", "scales the command".
const char* name_of(VoltageUse use);

/// Which signals of a recording make motor data.
struct MotorSignals {
  std::string command;  ///< rotor_command, pwm or motor_power
  std::string unit;     ///< of the command
  VoltageUse voltage = VoltageUse::none;
  double reference_V = 0;  ///< of product: the command counts as it is at this voltage
  double period_s = 0;     ///< between samples of rotor_speed, median
  Eigen::Index rotors = 0;
};

/// The command is `wanted`, or the first there is of rotor_command, pwm, motor_power. Errors: no measured
/// rotor speed, no command.
Result<MotorSignals> motor_signals(const recording::Recording& recording, const std::string& wanted);

/// Stretches of at least a second in which the rotor turns (above a fifth of its fast speed, 95 % of the
/// samples are slower) and nothing is missing for more than five periods; speeds as magnitudes. The command
/// is held between its samples, the rest is linear. Errors: the rotor never turns; a command that does not
/// move.
Result<identification::Dataset> rotor_data(const recording::Recording& recording, const MotorSignals& signals,
                                           Eigen::Index rotor);

}  // namespace omniflight::cli
