// Flight time in real time: seconds of CLOCK_MONOTONIC since an epoch that all parts of a run on one machine
// share. A step of the system clock (NTP, an operator) moves nothing.
#pragma once

#include <time.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace omniflight::components {

class WallPace {
 public:
  /// epoch_ns: CLOCK_MONOTONIC at flight time zero [ns]; 0 means now.
  explicit WallPace(std::int64_t epoch_ns = 0) : epoch_ns_(epoch_ns > 0 ? epoch_ns : monotonic_ns()) {}
  double now() const { return 1e-9 * static_cast<double>(monotonic_ns() - epoch_ns_); }  ///< s
  /// Sleeps until the flight time t [s]; returns at once when it has passed. The kernel is given the instant
  /// and not a duration, which would begin late where the thread is preempted between now() and the call.
  void sleep_until(double t) const {
    if (!(t > now())) return;
    const std::int64_t at_ns = epoch_ns_ + std::llround(1e9 * t);
    const timespec at{.tv_sec = at_ns / 1'000'000'000, .tv_nsec = at_ns % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
    }
  }

 private:
  static std::int64_t monotonic_ns() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  }
  std::int64_t epoch_ns_;
};

}  // namespace omniflight::components
