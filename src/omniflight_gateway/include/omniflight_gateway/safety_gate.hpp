// The last gate before the motors: a pure state machine, time passed in. It lets through only commands that
// are finite, in range, fresh, in order and reachable, counts what it refuses by reason, and winds the rotors
// down on its own when the commands stop coming. The descent begins as soon as the newest command is older
// than fresh_for_s: no command is repeated to the boards beyond that age. Until stale_after_s a new command
// ends the descent; after it, or after a trip, there is no way back but stopped, then arm() again.
#pragma once

#include <array>
#include <cstdint>
#include <omniflight_core/result.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace omniflight::gateway {

struct GateConfig {
  std::size_t rotors = 8;
  double max_speed_radps = 0.0;          ///< rad/s, |speed| a command may have; required
  double max_acceleration_radps2 = 1e4;  ///< rad/s^2, largest change of command per second
  /// s, age up to which a command is sent as it is; older, the speeds fall by 1/ramp_s per second. One
  /// control period of 100 Hz and 5 ms for the way over the bus.
  double fresh_for_s = 0.015;
  double stale_after_s = 0.1;  ///< s, age of the newest command from which there is no way back
  double ramp_s = 0.5;         ///< s, from the last command to zero
  /// s, longest gap between two updates that counts as silence of the commander. What is longer is sleep of
  /// the gate's own process, during which no command could be offered.
  double own_sleep_s = 0.02;
  double future_tolerance_s = 0.01;  ///< s, how far a stamp may be ahead of now
};

enum class GateState {
  disarmed,  ///< nothing accepted, rotors stopped, may be armed
  armed,     ///< commands pass
  fading,    ///< no fresh command: the speeds fall; a new command leads back to armed
  ramping,   ///< winding down to zero; nothing accepted
  stopped,   ///< wound down after a trip; nothing accepted until arm()
};

std::string_view to_string(GateState state);

enum class Refusal {
  not_armed,     ///< disarmed, winding down or stopped
  wrong_count,   ///< not one speed per rotor
  not_finite,    ///< NaN or infinity in a speed or stamp
  too_fast,      ///< |speed| over max_speed_radps
  stale,         ///< stamp older than stale_after_s
  from_future,   ///< stamp ahead of now by more than future_tolerance_s
  out_of_order,  ///< stamp not after the last accepted one
  too_sudden,    ///< change faster than max_acceleration_radps2 since the last accepted command
};
inline constexpr std::size_t kRefusalCount = 8;
std::string_view to_string(Refusal refusal);

/// Why the gate left the armed state.
enum class Trip {
  none,
  requested,
  stale_command,
  link_lost,
  board_emergency,
  clock,
  failsafe,        ///< the controller's ladder
  emergency_stop,  ///< the operator's
};
inline constexpr std::size_t kTripCount = 8;
std::string_view to_string(Trip trip);

/// What goes to the boards now.
struct GateOutput {
  GateState state = GateState::disarmed;
  std::span<const double> speeds_radps;  ///< rad/s by global rotor id; valid until the next call
  bool stop_motors = true;               ///< send the boards' stop instead of speeds
};

class SafetyGate {
 public:
  static Result<SafetyGate> create(const GateConfig& config);

  /// Allowed from disarmed and stopped. The first command has stale_after_s to come; speeds start from zero.
  Status arm(double now_s);
  /// Winds down and ends in stopped. Without effect unless armed or fading. The first trip's reason is kept
  /// until arm().
  void trip(Trip reason, double now_s);
  /// Stops at once, from any state.
  void cut(Trip reason);

  /// Offers one command, speeds [rad/s] by global rotor id. Empty when accepted, else why not (also counted).
  std::optional<Refusal> offer(std::span<const double> speeds_radps, double stamp_s, double now_s);

  /// Advances the watchdog and the ramp, which continues from where fading has arrived. A clock that is not
  /// finite or runs back by more than stale_after_s trips.
  GateOutput update(double now_s);

  GateState state() const { return state_; }
  /// Armed, with or without a fresh command.
  bool passes() const { return state_ == GateState::armed || state_ == GateState::fading; }
  Trip trip_reason() const { return reason_; }
  std::uint64_t accepted() const { return accepted_; }
  std::uint64_t refused(Refusal refusal) const { return refused_[static_cast<std::size_t>(refusal)]; }
  std::uint64_t refused() const;
  const GateConfig& config() const { return config_; }

 private:
  explicit SafetyGate(const GateConfig& config);
  void fade(double elapsed_s);
  std::optional<Refusal> judge(std::span<const double> speeds, double stamp_s, double now_s) const;

  GateConfig config_;
  GateState state_ = GateState::disarmed;
  Trip reason_ = Trip::none;
  double newest_stamp_s_ = 0.0;  ///< of the last accepted command, or the time of arming
  double silence_s_ = 0.0;       ///< age of that command, without the gate's own sleep
  double scale_ = 0.0;           ///< 1: speeds as commanded, 0: wound down
  double last_now_s_ = 0.0;
  std::vector<double> accepted_speeds_, output_;
  std::uint64_t accepted_ = 0;
  std::array<std::uint64_t, kRefusalCount> refused_{};
};

}  // namespace omniflight::gateway
