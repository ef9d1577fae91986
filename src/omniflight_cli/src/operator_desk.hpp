// The operator's words to a flight: emergency stop, wind down, land, hold, resume; and what the gate answers.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::cli {

inline constexpr double kMeet = 2.0;  ///< s until the participants of a run are found

class OperatorDesk {
 public:
  /// Joins the domain of a run.
  static Result<std::unique_ptr<OperatorDesk>> join(int domain);

  /// arm | cut | stop | land | hold | none, to everybody who listens now or later.
  Status say(const std::string& wish);
  /// Waits until somebody listens to wishes; false after the timeout [s].
  bool wait_for_listener(double timeout_s) const;
  /// Waits until a gate is found that can answer; false after the timeout [s].
  bool wait_for_gate(double timeout_s) const;
  /// Waits until a gate says that the rotors are stopped; false after the timeout [s].
  bool wait_for_stop(double timeout_s) const;
  /// Waits until a gate says that it is armed; false after the timeout [s].
  bool wait_for_arming(double timeout_s) const;
  /// The last words of the gate: "armed", "stopped: emergency_stop"; empty before any.
  std::string gate() const;

 private:
  OperatorDesk() = default;
  mutable std::mutex mutex_;
  std::string gate_;  ///< guarded by mutex_
  std::optional<bus::Participant> participant_;
  bus::Message<msgs::std_msgs::String> message_;
  std::optional<bus::Publisher<msgs::std_msgs::String>> wish_;
  std::optional<bus::Subscription<msgs::diagnostic_msgs::DiagnosticArray>> subscription_;
};

/// Domains that runs of this machine hold.
std::vector<int> domains_in_use();

/// Keys of a terminal, one at a time and without Enter, while it exists. Without a terminal there are none.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;
  bool there() const { return raw_; }
  /// A key that was pressed since the last call.
  std::optional<char> key();

 private:
  struct Saved;
  std::unique_ptr<Saved> saved_;
  bool raw_ = false;
};

/// The wish behind a key: a arms, space or e cuts, s winds down, l lands, h holds, r resumes; empty for
/// others.
std::string wish_of_key(char key);

}  // namespace omniflight::cli
