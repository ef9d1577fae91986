// Whether the accelerometer's columns are body axes.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace omniflight::diagnosis {

/// Some logs hold the estimator's specific force in the world instead of the sensor's in the body: then its
/// horizontal part follows the change of the velocity, where a body that leans to accelerate feels none.
/// `force` n x 3 [m/s^2], `acceleration` n x 3 [m/s^2] world, `q` n x 4 world<-body (w, x, y, z); rows with
/// `use` zero are left out. True only when the world fits clearly better, which takes sideways motion.
bool force_is_in_world(const Eigen::MatrixXd& force, const Eigen::MatrixXd& acceleration,
                       const Eigen::MatrixXd& q, const std::vector<char>& use, double gravity);

}  // namespace omniflight::diagnosis
