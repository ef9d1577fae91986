// Hypotheses outside the library that depend on time only: a sinusoidal force or torque along one axis.
#pragma once

#include "../search/hypothesis.hpp"

namespace omniflight::diagnosis {

struct Pulsation {
  Pattern pattern;  ///< cosine and sine per flight, rows x (2 flights) [N, Nm], not whitened
  /// Resolvable frequencies among which this is the strongest (look-elsewhere correction)
  double distinct = 1;
};

/// One per axis, at the frequency [Hz] with the largest gain in log-likelihood under this noise; between 8
/// periods in the longest flight and 10 Hz (at most half the Nyquist frequency).
std::vector<Pulsation> make_pulsations(const RegressionProblem& problem, const NoiseModel& noise);

}  // namespace omniflight::diagnosis
