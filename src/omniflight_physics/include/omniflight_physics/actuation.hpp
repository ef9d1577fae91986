// What stands between a rotor command and the rotor speed, and between a tilt command and the tilt.
#pragma once

#include <limits>
#include <vector>

#include "omniflight_core/frames.hpp"

namespace omniflight::physics {

/// Begins as the vehicle file tells (nominal_actuation); effects change it before a flight
/// (Effect::alter_actuation); Actuators carries it out, in the order of the fields. The default is an ideal
/// drive: every alteration is absent.
struct Actuation {
  /// Commanded wrench times this (force x y z, torque x y z, body): an allocator or controller that is set up
  /// for another vehicle. The null space of the rotors keeps its command.
  Vec6 wrench_gain = Vec6::Ones();
  double command_period = 0;      ///< s, commands are taken over once a period and held; 0 = every step
  double command_step = 0;        ///< rad/s, resolution of a command; 0 = exact
  std::vector<double> delay;      ///< s, a rotor
  double dead_speed = 0;          ///< rad/s, a smaller commanded magnitude stops the rotor
  double reversal_dwell = 0;      ///< s, a rotor rests so long between two directions
  double battery_voltage = 16.8;  ///< V, open circuit at the start
  double battery_resistance = 0;  ///< ohm
  double battery_drop = 0;        ///< V/J, open-circuit voltage lost per energy drawn
  double open_loop = 1;           ///< 1: speed follows the voltage; 0: only the largest speed does
  double drive_efficiency = 0.7;  ///< mechanical power per electrical power
  double speed_limit_scale = 1;   ///< 1, on the largest speed of every rotor
  double slew_limit = std::numeric_limits<double>::infinity();  ///< rad/s^2, largest |dOmega/dt|
  std::vector<double> time_constant;                            ///< s, a rotor
  double tilt_time_constant = 0;                                ///< s
  double tilt_backlash = 0;                                     ///< rad, full width of the play

  friend bool operator==(const Actuation&, const Actuation&) = default;
};

}  // namespace omniflight::physics
