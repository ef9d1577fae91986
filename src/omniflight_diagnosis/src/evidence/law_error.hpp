// A law is right up to a relative error that drifts: its wrench times hats of time, forces and torques apart.
#pragma once

#include "noise_model.hpp"
#include "set_coordinates.hpp"

namespace omniflight::diagnosis {

/// Whitened derivatives of the residual by these errors, of all laws among the members; of standard deviation
/// `law_error` [1] each. None where that is zero.
Eigen::MatrixXd law_error_columns(const RegressionProblem& problem, const NoiseModel& noise,
                                  const std::vector<Hypothesis>& hypotheses, double law_error,
                                  const std::vector<SetMember>& members);

/// SetCoordinates::log_integral where the last `law` coordinates are errors of laws. How wrong a law is, is
/// unknown itself: a mass is exact, a wake is not. The mean over RMS errors that are equally likely.
/// Deviations are with the largest of them: an estimate is not surer than its law.
double log_integral_over_law_errors(const SetCoordinates& coordinates, const Eigen::VectorXd& u,
                                    const Eigen::MatrixXd& precision, const Eigen::VectorXd& gradient,
                                    Eigen::Index law);

}  // namespace omniflight::diagnosis
