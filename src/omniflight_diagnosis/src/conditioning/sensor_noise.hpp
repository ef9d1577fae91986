// What noise of the sensors does to the wrench residual: added to a recording that is conditioned once more,
// so that whatever averages, differentiates and aligns the signals does so with the noise.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// RMS white noise of the noisiest component in samples [from, to), from third differences, which cancel
/// motion that is quadratic over four samples (variance 20 times that of the noise).
double white_noise(const recording::Signal& signal, Eigen::Index from, Eigen::Index to);

/// Whether turbulence is told, and the noise of the sensors that this flight's accelerations come from.
bool noise_is_told(const Flight& flight, const ToldNoise& noise);

/// Adds white normal noise of the told size to the signals of these sensors; the seed is fixed.
void add_noise(const ToldNoise& noise, recording::Recording& recording);

/// A recording of a simulator without any noise gets that of good sensors, white: what is smaller is told by
/// no real flight, and where there is none at all every error of arithmetic would be physics. Returns whether
/// it did; one whose signals have other widths, or noise in one of them, is left as it is.
bool add_missing_noise(recording::Recording& recording);

/// Wrench residual of `noisier` minus that of `flight` [N and Nm, samples x 6], which are of one size.
Eigen::MatrixXd residual_between(const Flight& flight, const Flight& noisier, const Vec3& center_of_mass);

}  // namespace omniflight::diagnosis
