// Regressors of the calibration: parameters of vehicle and sensors that are known within a tolerance only.
#pragma once

#include "regression_problem.hpp"

namespace omniflight::diagnosis {

/// Columns [N, Nm, channel-major] per standard deviation of each parameter, at predicted and at measured
/// states. `log_voltage`: per sample ln(voltage / mean), for a thrust that is modelled from duty cycles.
Calibration calibrate(const RegressionProblem& problem, std::span<const Flight* const> flights,
                      const vehicle::Vehicle& vehicle, const Options& options,
                      const std::vector<double>& log_voltage);

}  // namespace omniflight::diagnosis
