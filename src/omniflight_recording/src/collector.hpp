// Gathers samples of many signals in any order and turns them into a clean Recording.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

class Collector {
 public:
  /// Adds one sample. Non-finite rows and rows of another width than most are counted, not stored.
  void add(const std::string& signal, double t_s, const double* values, std::size_t width);
  void describe(const std::string& signal, const std::string& unit, const std::string& source);
  void forget(const std::string& signal) { all_.erase(signal); }
  /// Samples so far; those that were refused do not count.
  std::size_t count(const std::string& signal) const;
  std::size_t refused(const std::string& signal) const;
  void rename(const std::string& from, const std::string& to);
  /// Moves all its samples in time [s].
  void shift(const std::string& signal, double by_s);
  /// Sorts by time, drops repeated times, normalises quaternions, notes what was dropped, sets the duration.
  void finish(Recording& recording);

 private:
  struct Samples {
    std::string unit, source;
    std::vector<double> t, values;
    std::size_t width = 0;
    std::uint64_t refused = 0, misfits = 0;
  };
  std::map<std::string, Samples> all_;
};

}  // namespace omniflight::recording
