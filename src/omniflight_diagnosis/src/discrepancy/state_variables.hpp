// Quantities of the vehicle's own state on which a mismatch may depend, to be told in words and numbers.
#pragma once

#include "../regression/regression_problem.hpp"

namespace omniflight::diagnosis {

struct StateVariable {
  std::string name, unit;
  Eigen::VectorXd x;   ///< measured, a sample each
  bool hinge = false;  ///< a kink is looked for
};

std::vector<StateVariable> state_variables(const RegressionProblem& problem);

/// Largest minus smallest value.
double spread(const Eigen::VectorXd& x);

}  // namespace omniflight::diagnosis
