#include "omniflight_gateway/safety_gate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace omniflight::gateway {
namespace {

Status require_positive(double value, const char* field, const char* unit) {
  if (std::isfinite(value) && value > 0) return {};
  return bad_input("must be a positive number of " + std::string(unit) + ", is " + std::to_string(value),
                   field, "Set it in the gateway's parameters");
}

}  // namespace

std::string_view to_string(GateState state) {
  static constexpr std::array<std::string_view, 5> names = {"disarmed", "armed", "fading", "ramping",
                                                            "stopped"};
  return names[static_cast<std::size_t>(state)];
}

std::string_view to_string(Refusal refusal) {
  static constexpr std::array<std::string_view, kRefusalCount> names = {
      "not_armed", "wrong_count", "not_finite",   "too_fast",
      "stale",     "from_future", "out_of_order", "too_sudden"};
  return names[static_cast<std::size_t>(refusal)];
}

std::string_view to_string(Trip trip) {
  static constexpr std::array<std::string_view, kTripCount> names = {
      "none",  "requested", "stale_command", "link_lost", "board_emergency",
      "clock", "failsafe",  "emergency_stop"};
  return names[static_cast<std::size_t>(trip)];
}

SafetyGate::SafetyGate(const GateConfig& config)
    : config_(config), accepted_speeds_(config.rotors, 0.0), output_(config.rotors, 0.0) {}

Result<SafetyGate> SafetyGate::create(const GateConfig& config) {
  if (config.rotors == 0 || config.rotors > 64) {
    return bad_input("must be 1 to 64, is " + std::to_string(config.rotors), "rotors",
                     "Set it to the vehicle's number of rotors");
  }
  const struct {
    double value;
    const char *field, *unit;
  } fields[] = {{config.max_speed_radps, "max_speed_radps", "rad/s"},
                {config.max_acceleration_radps2, "max_acceleration_radps2", "rad/s^2"},
                {config.fresh_for_s, "fresh_for_s", "s"},
                {config.stale_after_s, "stale_after_s", "s"},
                {config.own_sleep_s, "own_sleep_s", "s"},
                {config.ramp_s, "ramp_s", "s"},
                {config.future_tolerance_s, "future_tolerance_s", "s"}};
  for (const auto& f : fields) {
    if (auto ok = require_positive(f.value, f.field, f.unit); !ok) return Failure(ok.error());
  }
  if (config.fresh_for_s > config.stale_after_s) {
    return bad_input("is " + std::to_string(config.fresh_for_s) +
                         " s, longer than stale_after_s = " + std::to_string(config.stale_after_s) + " s",
                     "fresh_for_s", "Set it to one control period and the way over the bus");
  }
  return SafetyGate(config);
}

Status SafetyGate::arm(double now_s) {
  if (!std::isfinite(now_s)) return bad_input("the clock is not finite", "arm", "Check the clock");
  if (passes()) return bad_input("is armed already", "arm", "Disarm first");
  if (state_ == GateState::ramping) {
    return bad_input("the rotors are still winding down", "arm", "Wait until the gate says stopped");
  }
  state_ = GateState::armed;
  reason_ = Trip::none;
  newest_stamp_s_ = last_now_s_ = now_s;
  silence_s_ = 0.0;
  scale_ = 1.0;
  std::fill(accepted_speeds_.begin(), accepted_speeds_.end(), 0.0);
  return {};
}

void SafetyGate::trip(Trip reason, double now_s) {
  if (!passes()) return;
  state_ = GateState::ramping;
  reason_ = reason;
  if (std::isfinite(now_s)) last_now_s_ = std::max(last_now_s_, now_s);
}

void SafetyGate::cut(Trip reason) {
  if (reason_ == Trip::none) reason_ = reason;
  state_ = GateState::stopped;
}

std::optional<Refusal> SafetyGate::judge(std::span<const double> speeds, double stamp_s, double now_s) const {
  if (!passes()) return Refusal::not_armed;
  if (speeds.size() != config_.rotors) return Refusal::wrong_count;
  if (!std::isfinite(stamp_s) || !std::isfinite(now_s)) return Refusal::not_finite;
  for (const double s : speeds) {
    if (!std::isfinite(s)) return Refusal::not_finite;
  }
  for (const double s : speeds) {
    if (std::abs(s) > config_.max_speed_radps) return Refusal::too_fast;
  }
  if (now_s - stamp_s > config_.stale_after_s) return Refusal::stale;
  if (stamp_s - now_s > config_.future_tolerance_s) return Refusal::from_future;
  if (stamp_s <= newest_stamp_s_) return Refusal::out_of_order;
  // A silence longer than the watchdog's trips it, so the time a jump may claim is bounded by stale_after_s.
  const double elapsed_s = std::min(stamp_s - newest_stamp_s_, config_.stale_after_s);
  const double reachable = config_.max_acceleration_radps2 * elapsed_s * (1 + 1e-9);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    if (std::abs(speeds[i] - accepted_speeds_[i]) > reachable) return Refusal::too_sudden;
  }
  return std::nullopt;
}

std::optional<Refusal> SafetyGate::offer(std::span<const double> speeds_radps, double stamp_s, double now_s) {
  update(now_s);  // a late command must not overtake the watchdog
  const auto refusal = judge(speeds_radps, stamp_s, now_s);
  if (refusal) {
    ++refused_[static_cast<std::size_t>(*refusal)];
    return refusal;
  }
  std::copy(speeds_radps.begin(), speeds_radps.end(), accepted_speeds_.begin());
  newest_stamp_s_ = stamp_s;
  silence_s_ = std::max(0.0, now_s - stamp_s);
  state_ = GateState::armed;
  scale_ = 1.0;
  ++accepted_;
  return std::nullopt;
}

/// Armed or fading: how far the speeds have fallen since the newest command stopped being fresh.
void SafetyGate::fade(double elapsed_s) {
  silence_s_ += std::min(elapsed_s, config_.own_sleep_s);
  scale_ = std::min(scale_, 1.0 - (silence_s_ - config_.fresh_for_s) / config_.ramp_s);
  state_ = scale_ < 1.0 ? GateState::fading : GateState::armed;
  // Compared as judge() does, so that a command is either accepted or outlived, never neither.
  if (scale_ <= 0.0 || last_now_s_ - newest_stamp_s_ > config_.stale_after_s)
    trip(Trip::stale_command, last_now_s_);
}

GateOutput SafetyGate::update(double now_s) {
  const bool clock_ok = std::isfinite(now_s) && now_s >= last_now_s_ - config_.stale_after_s;
  if (!clock_ok && state_ != GateState::disarmed) {
    // Without a clock there is no ramp to time either.
    cut(Trip::clock);
  } else if (clock_ok) {
    const double elapsed_s = std::max(0.0, now_s - last_now_s_);
    last_now_s_ += elapsed_s;
    if (passes())
      fade(elapsed_s);
    else if (state_ == GateState::ramping)
      scale_ -= elapsed_s / config_.ramp_s;
    if (state_ == GateState::ramping && scale_ <= 0.0) state_ = GateState::stopped;
  }
  const bool stop = state_ == GateState::disarmed || state_ == GateState::stopped;
  for (std::size_t i = 0; i < output_.size(); ++i) output_[i] = stop ? 0.0 : scale_ * accepted_speeds_[i];
  return {state_, output_, stop};
}

std::uint64_t SafetyGate::refused() const {
  return std::accumulate(refused_.begin(), refused_.end(), std::uint64_t{0});
}

}  // namespace omniflight::gateway
