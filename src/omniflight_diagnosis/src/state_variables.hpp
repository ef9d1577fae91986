// Quantities of the vehicle's own state on which a mismatch may depend; no hypothesis from the library.
#pragma once

#include "whitening.hpp"

namespace omniflight::diagnosis {

struct StateVariable {
  std::string name, unit;
  Eigen::VectorXd x;
  bool hinge = false;  ///< a kink is looked for
};

std::vector<StateVariable> state_variables(const Problem& problem);

/// Largest minus smallest value.
double spread(const Eigen::VectorXd& x);

/// Every channel without what the variables and a constant explain (ordinary least squares, a channel each).
/// dof: coefficients a channel.
Eigen::VectorXd without_variables(const Problem& problem, const Eigen::VectorXd& residual,
                                  const std::vector<StateVariable>& v, int& dof);

/// The noise of the flights: whitening fitted to what state variables, bends with height and the rotors' own
/// wrench cannot predict. A whitening fitted to the residual itself would take a slow effect for noise.
Whitening noise_model(const Problem& problem, const Options& options);

}  // namespace omniflight::diagnosis
