// Columns of a foreign table, grouped by their names into what may be one signal.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace omniflight::recording {

/// "Gyro_X [deg/s]": words {gyro}, component x, unit deg/s.
struct ColumnName {
  std::vector<std::string> words;  // small letters, without component and unit
  char component = 0;              // x, y, z, w, or n for a number; 0: none
  int number = 0;
  std::string unit;  // empty where the name has none
};
ColumnName parse_column_name(std::string_view name);

/// Columns whose names differ in the component only, in the order x y z, w x y z, or of their numbers.
struct ColumnGroup {
  std::vector<std::string> words;
  std::string unit;
  std::vector<int> columns;
  char kind = 0;  // v: x y z; q: w x y z; n: numbered; s: a single column
};
std::vector<ColumnGroup> group_columns(const std::vector<std::string>& header);

}  // namespace omniflight::recording
