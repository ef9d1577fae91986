// Page faults of the thread that runs a control loop, from its beginning to its end.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <optional>

namespace omniflight::components {

/// Page faults of the calling thread, minor and major, since it began.
inline std::uint64_t thread_page_faults() {
  rusage use{};
  if (getrusage(RUSAGE_THREAD, &use) != 0) return 0;
  return static_cast<std::uint64_t>(use.ru_minflt + use.ru_majflt);
}

/// Counts page faults between begin() and end(), which the thread of the loop calls. What the thread does
/// afterwards (words for the user, files) may fault and is not counted.
class LoopPageFaults {
 public:
  void begin() {
    begin_ = thread_page_faults();
    end_.reset();
  }
  /// Freezes the count; later calls change nothing.
  void end() {
    if (begin_ && !end_) end_ = thread_page_faults();
  }
  /// Until end(), or until now; 0 before begin().
  std::uint64_t count() const { return begin_ ? end_.value_or(thread_page_faults()) - *begin_ : 0; }

 private:
  std::optional<std::uint64_t> begin_, end_;
};

}  // namespace omniflight::components
