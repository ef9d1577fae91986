// A map to start from, of the names and sizes of a CSV's columns.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::recording {

struct MapDraft {
  std::string yaml;                  ///< omniflight.csv_map/1; loads as it is
  std::vector<std::string> guessed;  ///< what was taken for what, with unit, to be checked
  std::vector<std::string> unused;   ///< columns that no signal was made of, with their range
};

/// Groups columns by their names (`gyro_x` `gyro_y` `gyro_z`, `qw` ... `qz`, `rpm1` ...) and takes units from
/// names
/// ("[deg/s]", "_ms") or, where they have none, from sizes. An error when the file is no CSV, or no time or
/// no signal can be recognised.
Result<MapDraft> draft_csv_map(const std::filesystem::path& file);

}  // namespace omniflight::recording
