// Noise from what slow functions of place leave: fitted to the residual itself it would take slow effects for
// noise, in which they are then no longer found.
#pragma once

#include <memory>

#include "../search/hypothesis.hpp"

namespace omniflight::diagnosis {

/// Columns, rows x any number, their cosine amplitudes, and the sum of squares of each row of these.
struct SlowColumns {
  Eigen::MatrixXd raw, amplitudes;
  Eigen::VectorXd power;
};

/// Constant forces and torques, and smooth functions of place and rotor tilt.
/// What the rotors and the rates do is not among them: through feedback they follow the disturbance, and a
/// regression on them would take noise away.
SlowColumns slow_columns(const RegressionProblem& problem);

/// Noise of the residual less `known` (what a fitted set does, or zero) and less a ridge regression on
/// `slow`.
std::unique_ptr<NoiseModel> estimate_noise(const RegressionProblem& problem, const SlowColumns& slow,
                                           const Eigen::VectorXd& known, double temperature);

}  // namespace omniflight::diagnosis
