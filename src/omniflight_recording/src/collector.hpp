// Gathers samples of many signals in any order and turns them into a clean Recording.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

class Collector {
 public:
  /// Adds one sample. Non-finite rows and rows of another width than the first are counted, not stored.
  void add(const std::string& signal, double t_s, const double* values, std::size_t width);
  void describe(const std::string& signal, const std::string& unit, const std::string& source);
  void forget(const std::string& signal) { all_.erase(signal); }
  /// Sorts by time, drops repeated times, normalises quaternions, notes what was dropped, sets the duration.
  void finish(Recording& recording);

 private:
  struct Samples {
    std::string unit, source;
    std::vector<double> t, values;
    std::size_t width = 0;
    std::uint64_t refused = 0;
  };
  std::map<std::string, Samples> all_;
};

}  // namespace omniflight::recording
