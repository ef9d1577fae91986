// Which rotors do not turn as they are commanded. Pure: commands, measurements and time in, lost rotors out.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace omniflight::safety {

struct RotorWatchConfig {
  double commanded_share = 0.2;  ///< of the largest speed; a rotor that is to be slower tells nothing
  double reached_share = 0.25;   ///< of the speed it is to have; less for `patience` is a lost rotor
  double patience = 0.05;        ///< s, beyond the time constant of the rotor
  double reversal = 0.05;  ///< s more of a rotor that has just reversed: it may rest between two directions
};

struct WatchedRotor {
  double max_speed = 0;      ///< rad/s
  double time_constant = 0;  ///< s
  bool reverses = false;
};

/// A rotor is to have the speed of a first-order lag of its time constant behind its commands: one that
/// hovers about zero thrust, as the opposite one of a lost rotor does, is commanded to and fro faster than it
/// can turn. It is lost once it has been slower than reached_share of that speed, whatever the sense (many
/// speed sensors do not know it), for longer than its lag takes, or a reversal where there was one; it stays
/// lost until reset(): a rotor that is no longer commanded cannot tell.
class RotorWatch {
 public:
  /// At most 32 rotors.
  explicit RotorWatch(const std::vector<WatchedRotor>& rotors, RotorWatchConfig config = {});

  /// Measured speeds [rad/s, signed] at t [s] beside the command in force then. Spans of another size,
  /// numbers that are not finite and times that do not go on are ignored. True when a rotor was lost with it.
  bool add(double t, std::span<const double> command, std::span<const double> measured);

  /// For a while the rotors did not get the commands. The next sample is judged like the first one: its
  /// command is what the rotors are to have, and any of them may be reversing. What is lost stays lost.
  void interrupt();

  std::uint32_t lost() const { return lost_; }  ///< bit 0 is the first rotor
  void reset();

 private:
  RotorWatchConfig config_;
  bool could_be_reversing(std::size_t rotor) const;

  std::vector<WatchedRotor> rotors_;
  std::vector<double> expected_;     ///< rad/s, signed
  std::vector<double> reversed_at_;  ///< s, when its sense was last another one, or not known
  std::vector<double> slow_since_;   ///< s; NaN: turns as commanded
  double last_ = 0;
  bool begun_ = false;
  std::uint32_t lost_ = 0;
};

}  // namespace omniflight::safety
