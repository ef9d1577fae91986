// From conditioned flights to the posterior over what was left out.
#pragma once

#include "../evidence/noise_estimate.hpp"
#include "posterior.hpp"
#include "prediction_horizon.hpp"

namespace omniflight::diagnosis {

struct Inference {
  HorizonChoice horizon;
  std::unique_ptr<RegressionProblem> problem;
  std::unique_ptr<NoiseModel> noise;
  std::vector<Hypothesis> hypotheses;
  Eigen::VectorXd tolerances;  ///< of calibration, over those that are assumed or told
  Posterior posterior;
};

/// Wrench of a fitted set over all samples, calibration apart: what is expected from the samples before, or
/// with the measured states.
Eigen::VectorXd wrench_of_set(const RegressionProblem& problem, const std::vector<Hypothesis>& hypotheses,
                              const SetFit& set, States states);

Inference infer(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                const std::vector<const physics::Effect*>& effects, const Options& options);

}  // namespace omniflight::diagnosis
