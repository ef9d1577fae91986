// A vehicle as tools of ROS 2 draw it: URDF, with a joint for every tilt and every rotor.
#pragma once

#include <string>
#include <vector>

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::vehicle {

/// URDF with the links base_link (mass, inertia, collision shapes), and for rotor k = 1, 2, ... the joints
/// tilt_k (revolute about the tilt axis, of rotors that tilt) and rotor_k (continuous about the thrust axis).
std::string robot_description(const Vehicle& vehicle);

/// The joints of robot_description(): all rotors, then the tilts.
std::vector<std::string> joint_names(const Vehicle& vehicle);

}  // namespace omniflight::vehicle
