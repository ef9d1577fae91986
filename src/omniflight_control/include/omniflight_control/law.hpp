// What every control law has in common, and the table of laws.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "omniflight_control/controller.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::control {

struct LawConfig {
  ControllerConfig gains;
  /// Unit, body axes: the only direction of force of an underactuated vehicle, positive thrust along it. Zero
  /// for a vehicle whose attitude is free: then the reference's attitude is flown as it is.
  Vec3 thrust_axis_B = Vec3::Zero();
  double max_lean = to_radians(45);      ///< rad, of the thrust axis from upright
  double max_correction_speed = 2.0;     ///< m/s an axis, of the cascaded law's position loop
  double max_correction_rate = 6.0;      ///< rad/s an axis, of its attitude loop
  double disturbance_bandwidth = 15.0;   ///< rad/s, of the incremental law's estimate
  double actuator_time_constant = 0.03;  ///< s, lag between a command and its force, of the incremental law
};

/// Names of the laws that make_law knows: full_pose, thrust_vector, cascaded, incremental.
const std::vector<std::string>& law_names();

/// A law by its name. bad_input for an unknown name, a thrust axis that is neither zero nor of unit length,
/// and thrust_vector without a thrust axis or full_pose with one.
Result<std::unique_ptr<Law>> make_law(const std::string& name, const LawConfig& config);

}  // namespace omniflight::control
