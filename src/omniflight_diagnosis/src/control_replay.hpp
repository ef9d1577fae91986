// Reference to controller: what the told gains would have asked for on the recorded state.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Fits the gains that the logged command `qddr` follows (reference acceleration plus gains on position
/// error, velocity error and, where logged, its integral) and names controller_mismatch with the axes whose
/// gains differ from the told ones by more than 10 % and four standard errors. Adds nothing when the
/// reference, the command or the state is not logged.
void add_control(const recording::Recording& recording, const ToldController& told, Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
