// Flight time in real time: seconds of the system clock since an epoch that all parts of a run share.
#pragma once

#include <chrono>
#include <thread>

#include "omniflight_bus/publisher.hpp"

namespace omniflight::components {

class WallPace {
 public:
  /// epoch_ns: nanoseconds since 1970; 0 means now.
  explicit WallPace(std::int64_t epoch_ns = 0) : epoch_ns_(epoch_ns > 0 ? epoch_ns : bus::wall_clock_ns()) {}
  double now() const { return 1e-9 * static_cast<double>(bus::wall_clock_ns() - epoch_ns_); }  ///< s
  /// Sleeps until the flight time t [s]; returns at once when it has passed.
  void sleep_until(double t) const {
    const double wait = t - now();
    if (wait > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait));
  }

 private:
  std::int64_t epoch_ns_;
};

}  // namespace omniflight::components
