// Whether the motors of a log are in the order of the vehicle file, by the torques of the flight.
#pragma once

#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::cli {

struct MotorOrder {
  std::string not_judged;           ///< why nothing can be said; empty: it can
  Vec3 correlation = Vec3::Zero();  ///< between modelled and needed torque about x, y, z, as the log is
  std::vector<int> better;  ///< rotor i of the vehicle is motor better[i] of the log (from 0); empty: none
  Vec3 better_correlation = Vec3::Zero();
  bool spins_reversed = false;  ///< about z the torques are the other way round
};

/// Torque needed for the recorded motion, J dw/dt + w x (J w) (Euler's equation), against the torque of the
/// rotors by the vehicle file, B T, both without what is slower than a second. Their correlation does not
/// depend on scales of thrust or inertia. Up to eight rotors all orders are tried; one is proposed when it
/// explains roll and pitch (correlation above 0.5), the given one does not (below 0.3), and no other comes
/// near.
MotorOrder judge_motor_order(const recording::Recording& recording, const vehicle::Vehicle& vehicle);

/// One sentence, for people.
std::string to_text(const MotorOrder& order);

}  // namespace omniflight::cli
