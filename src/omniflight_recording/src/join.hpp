// One recording from the parts that a recorder split it into.
#pragma once

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

/// Appends a later part: signals on the clock of the first, counts of topics, notes with the part's name.
/// Samples that do not come after those before are left out and noted; so is a signal of another width.
void append_part(Recording& whole, Recording&& part, const std::string& name);

}  // namespace omniflight::recording
