// What of a vehicle, its sensors and its model is known only within a tolerance, as regressors.
#pragma once

#include "regression_problem.hpp"

namespace omniflight::diagnosis {

/// Columns for one standard deviation each. `drive`: of a thrust that is modelled from duty cycles, ln of the
/// speed and of the voltage over their means, a sample each.
Calibration calibrate(const RegressionProblem& problem, std::span<const Flight* const> flights,
                      const vehicle::Vehicle& vehicle, const Options& options,
                      const std::vector<std::array<double, 2>>& drive);

}  // namespace omniflight::diagnosis
