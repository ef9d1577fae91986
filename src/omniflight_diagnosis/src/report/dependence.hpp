// Description of the state dependence of a residual.
#pragma once

#include "../discrepancy/state_variables.hpp"

namespace omniflight::diagnosis {

/// For one channel of the residual [unit], e.g. "present throughout, mean -2.1 N; grows with height above
/// 0.62 m: -2.45 N per m". The mean is given above twice the `noise` (RMS that no model explains, in the same
/// unit), and the dependence on the state variable with the best linear (height: also one-sided) fit if it
/// explains at least 25 % of the variance. Empty when there is neither.
std::string dependence_of(const Eigen::VectorXd& residual, const std::vector<StateVariable>& variables,
                          const char* unit, double noise);

}  // namespace omniflight::diagnosis
