// The step of a fit whose unknowns have limits.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// The d with low <= d <= high that minimises 1/2 d'Hd - g'd; H (m x m) symmetric and positive semidefinite,
/// low <= 0 <= high, all finite. Primal active sets (Nocedal and Wright 2006, 16.5): a bound that is met is
/// kept, and let go where the slope leads back inside, so that it is the minimum also where columns hardly
/// differ.
Eigen::VectorXd bounded_step(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& low,
                             const Eigen::VectorXd& high);

}  // namespace omniflight::diagnosis
