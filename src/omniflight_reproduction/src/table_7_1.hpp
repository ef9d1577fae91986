#pragma once

#include "omniflight_reproduction/figure.hpp"

namespace omniflight::reproduction {

/// Tracking and power of both trajectories, and what each hidden cause explains of them.
Result<Finding> table_7_1(const Inputs& inputs);

}  // namespace omniflight::reproduction
