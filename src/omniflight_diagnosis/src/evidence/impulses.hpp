// Noise with heavy tails: samples at which the residual does what its spectrum does not let expect.
#pragma once

#include "noise_model.hpp"

namespace omniflight::diagnosis {

/// What lone samples have beside noise of the spectrum of `noise`, where `rest` (cosine amplitudes) is what a
/// regression leaves of the residual. A sample of a channel has an impulse with a probability of kImpulse, of
/// a normal size with kSize times the deviation of what its neighbours do not tell of it (a contaminated
/// normal distribution). The likeliest set of them and their sizes, one after the other.
Impulses find_impulses(const RegressionProblem& problem, const NoiseModel& noise,
                       const Eigen::VectorXd& rest);

}  // namespace omniflight::diagnosis
