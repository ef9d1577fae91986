// Child processes with deadlines: nothing is waited for without one, and nothing outlives its parent.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::jobs {

struct ChildOptions {
  std::string log;  ///< file for stdout and stderr
  int cpu = -1;     ///< processor to run on, -1: any
  /// Goes before ordinary programs (SCHED_RR) where the system allows it, so that a loaded machine does not
  /// starve it.
  bool prompt = false;
};

class Child {
 public:
  static Result<Child> start(const std::string& program, const std::vector<std::string>& arguments,
                             const ChildOptions& options);
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  ~Child();  ///< terminates what still runs

  /// Exit code once it has ended (128 + signal when it was killed).
  std::optional<int> poll();
  /// SIGTERM, without waiting.
  void ask_to_end();
  /// SIGTERM, then SIGKILL after the deadline [s]. Returns the exit code.
  int terminate(double deadline_s);
  pid_t pid() const { return pid_; }
  const std::string& name() const { return name_; }
  /// The first failure in its log, else its last line.
  std::string last_words() const;

 private:
  Child(pid_t pid, std::string name, std::string log)
      : pid_(pid), name_(std::move(name)), log_(std::move(log)) {}
  pid_t pid_ = -1;
  std::string name_, log_;
  std::optional<int> exit_;
};

}  // namespace omniflight::jobs
