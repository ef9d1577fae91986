// The flight that an analysis asks for, as a path: the mission file of its answer, flown in the same world.
#pragma once

#include <string>
#include <string_view>

#include "case_path.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::proof {

/// Reads the waypoints of a mission (schema omniflight.mission/1: start, by, attitude, hold_s, limits,
/// alpha_deg) and goes from rest to rest within its limits. An answer wrote the file, so nothing in it is
/// trusted: errors name line and field; a flight longer than 90 s or wider than 3 m is refused.
Result<Path> read_next_flight(std::string_view mission, const std::string& name);

}  // namespace omniflight::proof
