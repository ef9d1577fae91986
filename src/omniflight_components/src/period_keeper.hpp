// Keeps a control period on the flight clock: absolute deadlines, whole periods skipped when the machine was
// late, every missed one counted.
#pragma once

#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <vector>

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

/// Touches the memory that the calling thread will ask for, and lets the allocator keep it: what is returned
/// to the system has to be faulted in again, in the middle of a period.
inline void fault_memory_in() {
  constexpr std::size_t kHeap = 16u << 20, kBlock = 64u << 10, kStack = 256u << 10;
  mallopt(M_TRIM_THRESHOLD, 512 << 20);
  mallopt(M_MMAP_MAX, 0);
  std::vector<std::vector<char>> heap;
  heap.reserve(kHeap / kBlock);
  for (std::size_t taken = 0; taken < kHeap; taken += kBlock) heap.emplace_back(kBlock, '\1');
  char stack[kStack];
  explicit_bzero(stack, kStack);  // is never optimised away
}

/// Gives the calling thread a real-time priority and keeps the process's memory in RAM, where the system
/// allows it; says on stderr what it does not.
inline void ask_for_real_time(const char* name) {
  constexpr int kPriority = 20;  // above the components' SCHED_RR 10, below the kernel's threads at 50
  const sched_param priority{.sched_priority = kPriority};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority); error != 0)
    std::fprintf(stderr, "[%s] no real-time priority (%s): periods may be missed under load\n", name,
                 std::strerror(error));
  rlimit limit{};
  // With a limit later allocations would fail instead.
  const bool unlimited =
      geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
  if (!unlimited || mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0)
    std::fprintf(stderr, "[%s] memory is not locked (%s)\n", name,
                 unlimited ? std::strerror(errno) : "limit memlock");
  fault_memory_in();
}

}  // namespace omniflight::components
