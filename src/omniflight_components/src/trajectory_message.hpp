// A trajectory as trajectory_msgs/MultiDOFJointTrajectory, one transform, velocity and acceleration a joint.
// base_link: linear parts in world axes, angular parts in body axes of the reference. tilt, which may be
// absent: the tilt of the rotors as a rotation about x.
#pragma once

#include "conversions.hpp"

namespace omniflight::components {

using TrajectoryMessage = msgs::trajectory_msgs::MultiDOFJointTrajectory;

void to_message(const Trajectory& trajectory, TrajectoryMessage& out);
/// Checks sizes, finiteness and order. A message without tilt gives alpha = 0, see tells_tilt.
Result<Trajectory> from_message(const TrajectoryMessage& message);
bool tells_tilt(const TrajectoryMessage& message);

}  // namespace omniflight::components
