// Predetermined regressors: states of a stretch predicted from earlier samples.
#pragma once

#include <span>

#include "linear_prediction.hpp"
#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Situations of the samples [begin, end) in which body state, rotors and accelerations are predicted from
/// the samples up to `lag` samples before: measured state, rotor speeds and low-passed wrench residual at
/// that time, and the nominal wrench of the predicted rotors since. Measured regressors would correlate with
/// the noise under feedback: a disturbance moves the state and, through the controller, the rotors.
/// `inertia`: nominal 6 x 6, about the body origin [kg, kg m, kg m^2]; center_of_mass [m, body]; period [s].
std::vector<physics::Situation> predetermined(const Flight& flight, Segment segment, const Mat6& inertia,
                                              const Vec3& center_of_mass, double period, int lag);

/// Predictor over `lag` samples for signals that follow the commands. Regressors: the commanded wrench [N,
/// Nm] (samples of the segment x 6) at the horizon and up to 8 samples earlier, the state at the horizon, and
/// the reference.
LinearPrediction predict_from_commands(const Flight& flight, Segment segment,
                                       const Eigen::MatrixXd& commanded, double period, int lag);

/// Shortest horizon [s] at which smoothing kernels of the past and the present sample do not overlap: three
/// standard deviations (Flight::kernel_s) on both sides, and at least twice the look-ahead of interpolation
/// (Flight::reach_s).
double least_horizon(const Flight& flight);
/// The largest over several flights.
double least_horizon(std::span<const Flight* const> flights);

}  // namespace omniflight::diagnosis
