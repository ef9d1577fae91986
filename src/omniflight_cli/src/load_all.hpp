// Several recordings that a verb takes together.
#pragma once

#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::cli {

/// All of these, read with this map (--map); the error of the first that cannot be read.
Result<std::vector<recording::Recording>> load_all(const std::vector<std::string>& paths,
                                                   const std::string& map);

}  // namespace omniflight::cli
