// States of one stretch as they can be predicted from the samples before.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Situations of samples [begin, end) of the flight with body state and accelerations predicted one sample
/// ahead: measured state and low-passed wrench residual of the sample before, nominal wrench of the rotors at
/// the sample. A disturbance within a sample moves the measured state of that sample; regressors taken from
/// it would correlate with the noise. `inertia`: nominal, about the body origin (6 x 6).
std::vector<physics::Situation> predetermined(const Flight& flight, Segment segment, const Mat6& inertia,
                                              const Vec3& center_of_mass, double period);

}  // namespace omniflight::diagnosis
