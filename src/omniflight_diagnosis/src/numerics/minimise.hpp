// Minima of functions without derivatives, and how sharp they are.
#pragma once

#include <functional>

#include <Eigen/Dense>

namespace omniflight::diagnosis {

using Objective = std::function<double(const Eigen::VectorXd&)>;

struct Minimum {
  Eigen::VectorXd at;
  double value = 0;
};

/// Nelder and Mead's simplex (1965) from this point with these first steps until it is flat within
/// `tolerance`, and again from there while a step along any axis gains more than that, or until about so many
/// evaluations are spent. Infinite values are allowed.
Minimum minimise(const Objective& f, const Eigen::VectorXd& start, const Eigen::VectorXd& steps,
                 double tolerance, int evaluations);

/// Second derivatives at a minimum from finite differences, each with a step over which the function rises by
/// about one: also where it has kinks, or is sharp. No eigenvalue is below `least`.
Eigen::MatrixXd curvature(const Objective& f, const Minimum& minimum, const Eigen::VectorXd& steps,
                          double least);

}  // namespace omniflight::diagnosis
