// The library of effects as a text for people, from the same table that the simulator and the diagnosis use.
#pragma once

#include <string>

namespace omniflight::physics {

/// docs/reference/effects.md: every effect with equation, parameters, units, bounds, needs, aliases and
/// source, in the order of the table.
std::string effects_markdown();

}  // namespace omniflight::physics
