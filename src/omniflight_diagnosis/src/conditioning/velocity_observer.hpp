// Velocity from poses and accelerometer: a derivative of positions is mostly noise above one hertz.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace omniflight::diagnosis {

/// Velocity [m/s, world], n x 3, by a causal observer of position, velocity and a constant error of the
/// acceleration (Luenberger; three poles at 4 rad/s), so that a sample knows of none that is later. It begins
/// anew, at `derivative` [m/s, world, of the position], behind every sample that is not `used`, where that is
/// returned as it is. position: m, world; acceleration: m/s^2, world; all n x 3.
Eigen::MatrixXd observed_velocity(const Eigen::MatrixXd& position, const Eigen::MatrixXd& derivative,
                                  const Eigen::MatrixXd& acceleration, const std::vector<char>& used,
                                  double rate_hz);

}  // namespace omniflight::diagnosis
