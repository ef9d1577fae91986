// Whether the accelerometer signal is in body or in world axes.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace omniflight::diagnosis {

/// Some logs hold the specific force of the estimator in world axes. Its horizontal part then equals dv/dt,
/// whereas in the body axes of a vehicle that leans to accelerate it nearly vanishes. `force` n x 3 [m/s^2],
/// `acceleration` n x 3 [m/s^2] world, `q` n x 4 world<-body (w, x, y, z); rows with `use` zero are left out;
/// `gravity` [m/s^2]. True only when world axes fit clearly better, which requires horizontal motion.
bool force_is_in_world(const Eigen::MatrixXd& force, const Eigen::MatrixXd& acceleration,
                       const Eigen::MatrixXd& q, const std::vector<char>& use, double gravity);

}  // namespace omniflight::diagnosis
