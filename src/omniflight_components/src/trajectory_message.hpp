// A trajectory as trajectory_msgs/MultiDOFJointTrajectory: one transform, velocity and acceleration a point.
// Linear parts in world axes; angular parts in body axes of the reference.
#pragma once

#include "conversions.hpp"

namespace omniflight::components {

using TrajectoryMessage = msgs::trajectory_msgs::MultiDOFJointTrajectory;

void to_message(const Trajectory& trajectory, TrajectoryMessage& out);
/// Checks sizes, finiteness and order.
Result<Trajectory> from_message(const TrajectoryMessage& message);

}  // namespace omniflight::components
