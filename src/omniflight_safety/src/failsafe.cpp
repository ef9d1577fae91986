#include "omniflight_safety/failsafe.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace omniflight::safety {
namespace {

constexpr std::array<std::string_view, kActions> kActionNames = {"fly", "hold", "descend", "ramp_down",
                                                                 "off"};
constexpr std::array<std::string_view, kFaults> kFaultNames = {
    "recorder_lost",   "planner_lost",      "periods_missed", "operator_hold", "battery_low",
    "pose_lost",       "geofence_left",     "operator_land",  "battery_empty", "imu_lost",
    "rotors_lost",     "estimate_diverged", "geofence_far",   "commands_lost", "board_lost",
    "board_emergency", "operator_stop",     "clock_broken",   "emergency_stop"};

/// Share of its rate at which accumulated presence drains (PX4: the start delay refills at a quarter).
constexpr double kDrain = 0.25;

/// The operator's own wish lasts as long as the operator wants.
bool is_wish(Fault fault) { return fault == Fault::operator_hold; }

void accumulate(const LadderConfig& config, LadderState& s, double elapsed_s, const FaultSet& present) {
  for (std::size_t k = 0; k < kFaults; ++k) {
    const double delay_s = config.rungs[k].delay_s;
    if (present[k]) {
      s.quiet_s[k] = 0.0;
      s.present_s[k] = std::min(s.present_s[k] + elapsed_s, 2.0 * delay_s);
    } else {
      s.quiet_s[k] += elapsed_s;
      if (s.quiet_s[k] > delay_s) s.present_s[k] = std::max(0.0, s.present_s[k] - kDrain * elapsed_s);
    }
    s.fired[k] = present[k] ? s.fired[k] || s.present_s[k] >= delay_s : s.fired[k] && s.quiet_s[k] <= delay_s;
  }
}

void enter(LadderState& s, Action action, std::optional<Fault> cause) {
  s.since_s = s.last_s;
  s.action = action;
  s.cause = cause;
}

/// The worst that a fired fault asks for, and the first fault that asks for it.
std::pair<Action, std::optional<Fault>> worst(const LadderConfig& config, const FaultSet& fired) {
  std::pair<Action, std::optional<Fault>> out{Action::fly, {}};
  for (std::size_t k = 0; k < kFaults; ++k) {
    if (fired[k] && config.rungs[k].action > out.first) out = {config.rungs[k].action, static_cast<Fault>(k)};
  }
  return out;
}

}  // namespace

std::string_view to_string(Action action) { return kActionNames[static_cast<std::size_t>(action)]; }
std::string_view to_string(Fault fault) { return kFaultNames[index(fault)]; }

LadderConfig LadderConfig::standard() {
  LadderConfig c;
  const auto set = [&](Fault fault, Action action, double delay_s) {
    c.rungs[index(fault)] = {action, delay_s};
  };
  set(Fault::recorder_lost, Action::fly, 0.0);
  set(Fault::planner_lost, Action::fly, 0.0);
  set(Fault::periods_missed, Action::hold, 1.0);
  set(Fault::operator_hold, Action::hold, 0.0);
  set(Fault::battery_low, Action::hold, 2.0);
  set(Fault::pose_lost, Action::descend, 0.2);  // and 0.3 s until it counts as lost (Limits)
  set(Fault::geofence_left, Action::descend, 0.1);
  set(Fault::operator_land, Action::descend, 0.0);
  set(Fault::battery_empty, Action::descend, 0.5);
  set(Fault::imu_lost, Action::ramp_down, 0.05);
  set(Fault::rotors_lost, Action::ramp_down, 0.05);
  set(Fault::estimate_diverged, Action::ramp_down, 0.2);
  set(Fault::geofence_far, Action::ramp_down, 0.0);
  set(Fault::commands_lost, Action::ramp_down, 0.1);
  set(Fault::board_lost, Action::ramp_down, 0.0);
  set(Fault::board_emergency, Action::ramp_down, 0.0);
  set(Fault::operator_stop, Action::ramp_down, 0.0);
  set(Fault::clock_broken, Action::off, 0.0);
  set(Fault::emergency_stop, Action::off, 0.0);
  return c;
}

Status check(const LadderConfig& config) {
  const auto refuse = [](const std::string& field, double value) {
    return bad_input("must be finite, not negative [s], is " + std::to_string(value), field,
                     "Set it in the failsafe parameters");
  };
  for (std::size_t k = 0; k < kFaults; ++k) {
    const double delay_s = config.rungs[k].delay_s;
    if (!std::isfinite(delay_s) || delay_s < 0)
      return refuse(std::string(kFaultNames[k]) + ".delay_s", delay_s);
  }
  if (!std::isfinite(config.hold_limit_s) || config.hold_limit_s < 0)
    return refuse("hold_limit_s", config.hold_limit_s);
  if (!std::isfinite(config.descend_limit_s) || config.descend_limit_s < 0)
    return refuse("descend_limit_s", config.descend_limit_s);
  if (!std::isfinite(config.ramp_s) || config.ramp_s <= 0) return refuse("ramp_s", config.ramp_s);
  return {};
}

Result<LadderState> arm(const LadderConfig& config, const LadderState& state, double now_s,
                        const FaultSet& present) {
  if (state.armed && state.action != Action::off)
    return bad_input("is armed already", "failsafe", "Land first");
  if (!std::isfinite(now_s)) return bad_input("the clock is not finite", "failsafe", "Check the clock");
  std::string reasons;
  for (std::size_t k = 0; k < kFaults; ++k) {
    if (!present[k]) continue;
    const auto fault = static_cast<Fault>(k);
    // what ends no flight begins none either: without a recorder or a planner nobody takes off
    if (config.rungs[k].action > Action::fly || fault == Fault::recorder_lost || fault == Fault::planner_lost)
      reasons += (reasons.empty() ? "" : ", ") + std::string(kFaultNames[k]);
  }
  if (!reasons.empty()) return bad_input("not armed: " + reasons, "failsafe", "Mend it, then arm again");
  LadderState s;
  s.armed = true;
  s.last_s = now_s;
  enter(s, Action::fly, {});
  return s;
}

LadderState step(const LadderConfig& config, const LadderState& state, double now_s, const FaultSet& present,
                 bool on_ground) {
  LadderState s = state;
  if (!s.armed) return s;
  FaultSet now = present;
  if (!std::isfinite(now_s) || now_s < s.last_s) now.set(index(Fault::clock_broken));
  const double elapsed_s = now[index(Fault::clock_broken)] ? 0.0 : now_s - s.last_s;
  s.last_s += elapsed_s;
  accumulate(config, s, elapsed_s, now);

  const auto [wanted, cause] = worst(config, s.fired);
  if (wanted > s.action || (wanted == Action::fly && s.action == Action::hold)) enter(s, wanted, cause);
  if (wanted == Action::hold && s.action == Action::hold && !s.fired[index(*s.cause)]) s.cause = cause;
  const double lasted_s = s.last_s - s.since_s;
  if (s.action == Action::hold && !is_wish(*s.cause) && lasted_s > config.hold_limit_s)
    enter(s, Action::descend, s.cause);
  else if (s.action == Action::descend && (on_ground || lasted_s > config.descend_limit_s))
    enter(s, Action::ramp_down, s.cause);
  else if (s.action == Action::ramp_down && lasted_s >= config.ramp_s)
    enter(s, Action::off, s.cause);
  return s;
}

}  // namespace omniflight::safety
