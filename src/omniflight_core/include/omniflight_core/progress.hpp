// Progress of long work: a bar with rate and remaining time on a terminal, plain lines otherwise. Ctrl-C as a
// flag.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace omniflight {

enum class SecondInterrupt {
  ends_at_once,
  is_ignored,  ///< for who has rotors to wind down; Ctrl-\ still ends at once
};
/// Installs handlers for SIGINT, SIGTERM and SIGHUP (a terminal that is closed; nohup keeps it ignored) that
/// set a flag. `second`: what another SIGINT does.
void install_interrupt_handler(SecondInterrupt second = SecondInterrupt::ends_at_once);
/// True once one of them arrived. Safe from any thread.
bool interrupted();

/// One piece of work with a known or unknown end, printed at most a few times a second.
class Progress {
 public:
  /// title and unit are printed as they are ("flights", "s"); total is in that unit. total <= 0: unknown
  /// length. quiet: prints nothing. Prints to stderr.
  Progress(std::string title, double total, std::string unit, bool quiet = false);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// done: amount finished so far, in the unit of total.
  void update(double done);
  /// Ends the line; called by the destructor as well.
  void finish();

 private:
  void print(bool last);
  std::string title_, unit_;
  double total_, done_ = 0.0;
  bool quiet_, terminal_, finished_ = false;
  std::chrono::steady_clock::time_point start_, last_print_;
};

}  // namespace omniflight
