// What the allocator could not give of what the controller asked.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Allocation (desired against allocated acceleration) of one recording, where logged: channels that miss by
/// more than a tenth.
std::vector<Mismatch> locate_allocation(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
