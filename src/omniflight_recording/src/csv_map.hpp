// Which columns of a CSV are which signals: read from the header (canonical) or from a map file (foreign).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::recording {

struct CsvSignal {
  std::string signal;
  std::string unit;
  std::vector<int> columns;  // by component
  double scale = 1.0;
  double offset = 0.0;    // value = text * scale + offset
  bool list = false;      // one column whose cells hold all components
  std::size_t width = 0;  // of a list: components in a cell; 0: as many as most have
  bool xyzw = false;      // order of the four numbers of a list that is an attitude; otherwise w x y z
  double held_s = 0.0;    // a sample that repeats the last one within this time is left out [s]; 0: none is
};

struct CsvLayout {
  int time_column = -1;
  double time_scale = 1.0;  // to seconds
  std::vector<CsvSignal> signals;
  std::vector<std::string> ignored;  // columns without a meaning
  std::filesystem::path found_map;  // the map that was found to fit; empty where none was needed or one given
};

/// By `map` (a file, or a name under configs/csv_maps) when one is given; otherwise by canonical names, or by
/// the first map under configs/csv_maps whose columns are all there. A canonical time column decides for
/// canonical names.
Result<CsvLayout> layout_of(const std::vector<std::string>& header, const std::string& file,
                            const std::filesystem::path& map);

}  // namespace omniflight::recording
