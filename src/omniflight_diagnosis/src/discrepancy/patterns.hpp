// Hypotheses outside the library: smooth functions of one state variable in one channel.
#pragma once

#include "../search/hypothesis.hpp"

namespace omniflight::diagnosis {

/// Prior standard deviation of a coefficient over RegressionProblem::scale (weight, or weight times lever).
/// Chosen.
inline constexpr double kPatternShare = 0.03;

/// One pattern per axis (six of the body, three forces along world axes) and state variable that the flights
/// vary. Pattern columns are wrenches per prior standard deviation, rows x 5 [N, Nm], not whitened.
std::vector<Pattern> make_patterns(const RegressionProblem& problem);

}  // namespace omniflight::diagnosis
