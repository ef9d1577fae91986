// Predetermined regressors: states of a stretch predicted from earlier samples.
#pragma once

#include <span>

#include "linear_prediction.hpp"
#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// From what regressors are predicted.
struct Horizon {
  double s = 0;  ///< nothing later than this before a sample is known, but for the reference
  /// Nor anything before it: no disturbance has moved what is predicted. Instruments are weak where the
  /// vehicle does not follow its reference.
  bool reference_alone = false;
};

/// Situations of the samples of all segments, one segment after the other, in which body state, rotors and
/// accelerations are predicted from the samples up to `lag` samples before, of the same segment: measured
/// state, rotor speeds and low-passed wrench residual at that time, and the nominal wrench of the predicted
/// rotors since. How the vehicle answers is learnt from all segments together: one between two gaps may be
/// too short to tell. Measured regressors would correlate with the noise under feedback: a disturbance moves
/// the state and, through the controller, the rotors. With `reference_alone` rates, velocity, accelerations
/// and rotors follow from Flight::reference only; place and attitude are still integrated from those `lag`
/// samples before.
/// `inertia`: nominal 6 x 6, about the body origin [kg, kg m, kg m^2]; center_of_mass [m, body]; period [s].
std::vector<physics::Situation> predetermined(const Flight& flight, const Mat6& inertia,
                                              const Vec3& center_of_mass, double period, int lag,
                                              bool reference_alone);

/// Predictor over `lag` samples for signals that follow the commands, learnt from all segments. Regressors:
/// the commanded wrench [N, Nm] (samples of all segments x 6) at the horizon and up to 8 samples earlier, the
/// state at the horizon, and the reference; or the reference alone.
LinearPrediction predict_from_commands(const Flight& flight, const Eigen::MatrixXd& commanded, double period,
                                       int lag, bool reference_alone);

/// Shortest horizon [s] at which smoothing kernels of the past and the present sample do not overlap: three
/// standard deviations (Flight::kernel_s) on both sides, and at least twice the look-ahead of interpolation
/// (Flight::reach_s).
double least_horizon(const Flight& flight);
/// The largest over several flights.
double least_horizon(std::span<const Flight* const> flights);

}  // namespace omniflight::diagnosis
