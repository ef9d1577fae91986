// How fast this thread is served, for work that cannot be interrupted.
#pragma once

#include <time.h>

#include <algorithm>

namespace omniflight::planning {

/// Compares wall time with the processor time of the thread that made it.
class Pace {
 public:
  Pace() : wall_(seconds(CLOCK_MONOTONIC)), own_(seconds(CLOCK_THREAD_CPUTIME_ID)) {}

  /// Wall time per processor time since construction: 1 on a processor of its own, at most 100.
  double slowdown() const {
    const double wall = seconds(CLOCK_MONOTONIC) - wall_, own = seconds(CLOCK_THREAD_CPUTIME_ID) - own_;
    return own > 0.0 ? std::clamp(wall / own, 1.0, 100.0) : 1.0;
  }

 private:
  static double seconds(clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  double wall_, own_;
};

}  // namespace omniflight::planning
