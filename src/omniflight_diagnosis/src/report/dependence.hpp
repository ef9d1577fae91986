// On what a mismatch depends, in words.
#pragma once

#include "../discrepancy/state_variables.hpp"

namespace omniflight::diagnosis {

/// "present throughout, mean -2.1 N; grows with height above 0.62 m: -2.45 N per m": of one channel of the
/// residual the state variable that explains most of it, where that is a quarter of its variance or more.
/// noise: RMS of what no model explains.
std::string dependence_of(const Eigen::VectorXd& residual, const std::vector<StateVariable>& variables,
                          const char* unit, double noise);

}  // namespace omniflight::diagnosis
