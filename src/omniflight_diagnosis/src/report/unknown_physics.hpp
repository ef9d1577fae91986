// Physics outside the library, in the terms of the answer.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Channel, variable, share of the residual `before` [N, Nm, all rows], parity and energy of a pattern that
/// was fitted; and, as the simulator flies it, the straight line through it.
Unexplained unexplained_of(const Inference& inference, const SetMember& pattern,
                           const Eigen::VectorXd& before);

}  // namespace omniflight::diagnosis
