// Physics that is in no library: smooth functions of declared state variables, a channel each.
#pragma once

#include "../search/hypothesis.hpp"

namespace omniflight::diagnosis {

/// One pattern for every channel and every variable that these flights vary; not whitened yet.
std::vector<Pattern> make_patterns(const RegressionProblem& problem);

}  // namespace omniflight::diagnosis
