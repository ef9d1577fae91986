// The failsafe ladder: from what is wrong to what is done about it. A pure function of state, faults and
// time.
//
//   fly -> hold -> descend -> ramp_down -> off
//
// The worst action that any fault asks for wins. Only hold leads back to fly, once every fault that asked for
// it is gone. Descent is flown to its end, the ramp cannot be left but to off, and off is final until arm().
// After the pattern of PX4's commander (FailsafeBase::update), see README.md.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <omniflight_core/result.hpp>
#include <optional>
#include <string_view>

namespace omniflight::safety {

/// What is done, in order of severity.
enum class Action : std::uint8_t {
  fly,        ///< follow the plan
  hold,       ///< stay where the vehicle is
  descend,    ///< straight down at a bounded speed, from wherever it is
  ramp_down,  ///< rotors to zero over the gate's ramp
  off,        ///< rotors stopped
};
inline constexpr std::size_t kActions = 5;
std::string_view to_string(Action action);

enum class Fault : std::uint8_t {
  recorder_lost,      ///< nothing is recorded any more
  planner_lost,       ///< nobody could send another trajectory
  periods_missed,     ///< the control loop does not keep its period
  operator_hold,      ///< the operator asks for hold
  battery_low,        ///< below the voltage at which a flight should end
  pose_lost,          ///< no believable pose; the IMU alone carries the estimate
  geofence_left,      ///< outside the test bed's fence
  operator_land,      ///< the operator asks to land
  battery_empty,      ///< below the voltage at which the rotors lose authority
  imu_lost,           ///< no angular rate: attitude cannot be kept
  rotors_lost,        ///< the rotors that still turn cannot carry the vehicle
  estimate_diverged,  ///< poses and estimate contradict each other for longer than noise explains
  geofence_far,       ///< beyond the fence's margin: the vehicle does not obey
  commands_lost,      ///< no fresh rotor command
  board_lost,         ///< a rotor board does not answer
  board_emergency,    ///< a rotor board reports an emergency
  operator_stop,      ///< the operator asks to wind down now (Ctrl-C)
  clock_broken,       ///< time is not finite or runs backwards
  emergency_stop,     ///< the operator cuts the rotors at once
};
inline constexpr std::size_t kFaults = 19;
std::string_view to_string(Fault fault);

using FaultSet = std::bitset<kFaults>;
constexpr std::size_t index(Fault fault) { return static_cast<std::size_t>(fault); }

/// What a fault asks for once it has been present for delay_s.
struct Rung {
  Action action = Action::fly;
  double delay_s = 0.0;
};

struct LadderConfig {
  std::array<Rung, kFaults> rungs;  ///< by Fault
  double hold_limit_s = 20.0;     ///< s a fault (not the operator) may keep the vehicle in hold; then descend
  double descend_limit_s = 30.0;  ///< s of descent without touching down; then ramp_down
  double ramp_s = 0.5;            ///< s of ramp_down; then off

  /// The documented ladder (README.md).
  static LadderConfig standard();
};
/// Every delay and limit finite and not negative, ramp positive.
Status check(const LadderConfig& config);

/// The ladder's whole memory. A value: copy it, compare it, start from any.
struct LadderState {
  bool armed = false;
  Action action = Action::off;
  std::optional<Fault> cause = {};          ///< of the present action; empty when fly, or off before arming
  double since_s = 0.0;                     ///< when the present action began
  double last_s = 0.0;                      ///< time of the last step
  std::array<double, kFaults> present_s{};  ///< s accumulated, see step()
  std::array<double, kFaults> quiet_s{};    ///< s since the fault was last present
  FaultSet fired;                           ///< faults whose delay is over
  bool operator==(const LadderState&) const = default;
};

/// Armed, flying. Refused while armed, and while a fault is present that would not let the vehicle fly; the
/// error names all of them.
Result<LadderState> arm(const LadderConfig& config, const LadderState& state, double now_s,
                        const FaultSet& present);

/// Advances to now_s with the faults that are present in [last_s, now_s]. A fault fires when its accumulated
/// presence exceeds its delay. The accumulated time drains, at a quarter of the rate, only after the fault
/// has been absent for its whole delay: a fault that chatters with 50 % duty fires within twice its delay,
/// and one that shows up for a moment every now and then never does. Touching the ground ends a descent.
LadderState step(const LadderConfig& config, const LadderState& state, double now_s, const FaultSet& present,
                 bool on_ground = false);

}  // namespace omniflight::safety
