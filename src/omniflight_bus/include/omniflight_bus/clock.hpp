// The time that components stamp with: the system clock, or simulated time set from the bus.
#pragma once

#include <atomic>
#include <cstdint>

#include "omniflight_bus/publisher.hpp"

namespace omniflight::bus {

/// Safe from any thread.
class Clock {
 public:
  /// Nanoseconds since 1970, or since the start of the simulation once set.
  std::int64_t now_ns() const {
    const std::int64_t ns = simulated_.load(std::memory_order_relaxed);
    return ns == unset ? wall_clock_ns() : ns;
  }
  /// From here on this is the time; set it from the stamps of ticks.
  void set_simulated(std::int64_t ns) { simulated_.store(ns, std::memory_order_relaxed); }
  bool simulated() const { return simulated_.load(std::memory_order_relaxed) != unset; }

 private:
  static constexpr std::int64_t unset = INT64_MIN;
  std::atomic<std::int64_t> simulated_{unset};
};

}  // namespace omniflight::bus
