// Several recordings that a verb takes together.
#pragma once

#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::cli {

/// How foreign logs are read: --map, and --axes ("enu" or "ned").
struct ReadAs {
  std::string map, axes = "enu";
};

/// One recording, read so.
Result<recording::Recording> load_as(const std::string& path, const ReadAs& as);

/// All of these; the error of the first that cannot be read.
Result<std::vector<recording::Recording>> load_all(const std::vector<std::string>& paths, const ReadAs& as);

}  // namespace omniflight::cli
