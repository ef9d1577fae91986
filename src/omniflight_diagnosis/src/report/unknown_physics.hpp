// Description of a fitted pattern outside the library.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Channel, variable, share of the residual `before` (all rows, N and Nm), parity and energy of a fitted
/// pattern, and a linear fit or sinusoid as a correction that the simulator can load.
Unexplained unexplained_of(const Inference& inference, const SetMember& pattern,
                           const Eigen::VectorXd& before);

}  // namespace omniflight::diagnosis
