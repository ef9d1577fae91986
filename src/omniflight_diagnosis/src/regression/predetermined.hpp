// States of one stretch as they can be predicted from the samples before.
#pragma once

#include <span>

#include "linear_prediction.hpp"
#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Situations of samples [begin, end) of the flight with body state, rotors and accelerations as the samples
/// up to `lag` samples before predict them: measured state, rotor speeds and low-passed wrench residual of
/// then, nominal wrench of the rotors in between. A disturbance within a sample moves the measured state
/// of that sample and, through the controller, its rotors; regressors taken from it would correlate with the
/// noise. `inertia`: nominal, about the body origin (6 x 6).
std::vector<physics::Situation> predetermined(const Flight& flight, Segment segment, const Mat6& inertia,
                                              const Vec3& center_of_mass, double period, int lag);

/// Prediction, over `lag` samples, of what follows commands: from the wrench that they ask for (N and Nm,
/// rows of the segment x 6) then and before, and from what a controller acts on.
LinearPrediction predict_from_commands(const Flight& flight, Segment segment,
                                       const Eigen::MatrixXd& commanded, double period, int lag);

/// Shortest horizon [s] over which nothing of the present sample is seen: the kernels under which signals
/// reach their samples end after three standard deviations, then's and now's; and as far as interpolation
/// between the samples of the slowest signal reads ahead of then and back from now.
double least_horizon(const Flight& flight);
/// The longest of these.
double least_horizon(std::span<const Flight* const> flights);

}  // namespace omniflight::diagnosis
