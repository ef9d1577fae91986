// State variables by which the report describes a residual.
#pragma once

#include "../regression/regression_problem.hpp"

namespace omniflight::diagnosis {

struct StateVariable {
  std::string name, unit;
  Eigen::VectorXd x;   ///< measured value per sample, in `unit`
  bool hinge = false;  ///< piecewise linear dependence is tried, too
};

/// Height, position, velocity (body axes; climb speed: world), inclination, rotor tilt and body rates of all
/// samples.
std::vector<StateVariable> state_variables(const RegressionProblem& problem);

/// Largest minus smallest value.
double spread(const Eigen::VectorXd& x);

}  // namespace omniflight::diagnosis
