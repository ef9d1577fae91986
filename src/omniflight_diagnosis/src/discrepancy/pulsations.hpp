// Physics that is in no library and follows nothing but time: a force or torque along one axis that pulsates
// at one frequency.
#pragma once

#include "../search/hypothesis.hpp"

namespace omniflight::diagnosis {

struct Pulsation {
  Pattern pattern;      ///< cosine and sine of each flight; not whitened yet
  double distinct = 1;  ///< frequencies that these flights can tell apart, out of which this is the strongest
};

/// One for every axis, at the frequency [Hz] that takes most from the residual in this noise.
std::vector<Pulsation> make_pulsations(const RegressionProblem& problem, const NoiseModel& noise);

}  // namespace omniflight::diagnosis
