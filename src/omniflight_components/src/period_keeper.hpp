// Keeps a control period on the flight clock: absolute deadlines, whole periods skipped when the machine was
// late, every missed one counted.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "wall_pace.hpp"

namespace omniflight::components {

class PeriodKeeper {
 public:
  PeriodKeeper(const WallPace& pace, double period_s) : pace_(pace), period_(period_s), next_(pace.now()) {}

  /// Sleeps until the next period begins; the flight time [s] at which it does.
  double wait() {
    next_ += period_;
    pace_.sleep_until(next_);
    const double now = pace_.now(), late = now - next_;
    ++periods_;
    longest_ = std::max(longest_, late);
    if (late >= period_) {  // a burst would find every command stale
      const double whole = std::floor(late / period_);
      missed_ += static_cast<std::uint64_t>(whole);
      next_ += whole * period_;
    }
    return now;
  }
  /// Flight time [s] at which the last period was to begin.
  double due() const { return next_; }
  std::uint64_t missed() const { return missed_; }
  std::uint64_t periods() const { return periods_ + missed_; }
  double longest_late_s() const { return longest_; }

 private:
  const WallPace& pace_;
  double period_, next_, longest_ = 0;
  std::uint64_t periods_ = 0, missed_ = 0;
};

}  // namespace omniflight::components
