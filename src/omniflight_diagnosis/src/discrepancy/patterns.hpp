// Physics that is in no library: smooth functions of declared state variables, a channel each.
#pragma once

#include "../search/hypothesis.hpp"

namespace omniflight::diagnosis {

/// Prior standard deviation of a coefficient over the weight, or weight times lever.
inline constexpr double kPatternShare = 0.03;

/// One pattern for every channel and every variable that these flights vary; not whitened yet.
std::vector<Pattern> make_patterns(const RegressionProblem& problem);

}  // namespace omniflight::diagnosis
