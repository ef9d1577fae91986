// Waits with a deadline for what other threads bring about.
#pragma once

#include <chrono>
#include <thread>

namespace omniflight::cli {

/// Asks every millisecond; false when `timeout_s` [s] have passed first, or where `give_up` says so.
template <class Condition, class GiveUp>
bool wait_until(Condition condition, double timeout_s, GiveUp give_up) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
  while (!condition()) {
    if (Clock::now() > end || give_up()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}
template <class Condition>
bool wait_until(Condition condition, double timeout_s) {
  return wait_until(condition, timeout_s, [] { return false; });
}

}  // namespace omniflight::cli
