// Who is alive: a beat of every process, with a lease and a deadline that the middleware watches over.
//
// A process that is stopped, hangs or is killed lets its lease end (DDS liveliness, MANUAL_BY_TOPIC), and
// those who watch are told at that moment, not when they look next.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "omniflight_bus/participant.hpp"

namespace omniflight::bus {

inline constexpr std::chrono::milliseconds heartbeat_lease{100};
inline constexpr const char* heartbeat_topic = "/omniflight/alive";  ///< std_msgs/String: who

/// Beats while it exists, four times a lease, on a thread of its own.
class Heartbeat {
 public:
  static Result<Heartbeat> start(const Participant& participant, const std::string& name,
                                 std::chrono::milliseconds lease);
  Heartbeat(Heartbeat&&) noexcept;
  Heartbeat& operator=(Heartbeat&&) noexcept;
  ~Heartbeat();

 private:
  struct State;
  explicit Heartbeat(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Hears everybody who beats with this lease or a shorter one.
class HeartbeatWatch {
 public:
  /// alive false: nothing was heard of `name` for silence_s; true: it is back after silence_s. Called on a
  /// thread of the middleware: be brief, never wait.
  using Callback = std::function<void(const std::string& name, bool alive, double silence_s)>;
  static Result<HeartbeatWatch> start(const Participant& participant, std::chrono::milliseconds lease,
                                      Callback callback);
  HeartbeatWatch(HeartbeatWatch&&) noexcept;
  HeartbeatWatch& operator=(HeartbeatWatch&&) noexcept;
  ~HeartbeatWatch();

 private:
  struct State;
  explicit HeartbeatWatch(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace omniflight::bus
