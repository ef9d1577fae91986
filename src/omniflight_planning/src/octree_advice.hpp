#pragma once

namespace omniflight::planning {

/// What to do about a map that cannot be read.
inline constexpr const char* kRemakeMap = "Make the map again with omniflight_make_test_bed or OctoMap";

}  // namespace omniflight::planning
