// A command for the motors of a bench, played through gateway and safety gate, and what the boards measured.
#pragma once

#include <functional>

#include "omniflight_gateway/gateway.hpp"
#include "omniflight_gateway/safety_gate.hpp"

namespace omniflight::gateway {

struct BenchConfig {
  double period_s = 0.01;        ///< between commands, 0.001 to 0.1
  double max_speed_radps = 0.0;  ///< of the gate; required
  double max_acceleration_radps2 = 2e4;
  double ramp_s = 1.0;                   ///< from standing to the first command
  double connect_s = 5.0;                ///< boards must answer within this
  std::optional<BoardGains> gains = {};  ///< sent to every rotor before the motors start
};

/// Time for the bench: real, or an emulator's. `advance` waits until a moment of `now` [s] and moves what has
/// to move meanwhile; it fails when that cannot be done.
struct BenchClock {
  std::function<double()> now;
  std::function<Status(double until_s)> advance;
  std::function<bool()> stop;  ///< true winds the motors down and ends the run
};

struct BenchRecord {
  std::vector<double> command_s, command_radps;  ///< s since the first command, rad/s of every rotor
  std::vector<RotorSample> rotors;               ///< times on the same clock
  std::vector<BatterySample> battery;
  std::uint64_t refused = 0, missed = 0;  ///< commands the gate refused, samples the line lost
  std::size_t gains_confirmed = 0;        ///< rotors whose board told the gains that were sent
  bool complete = false;                  ///< false: stopped by `stop`
};

/// Connects, starts the motors, ramps up, plays one command [rad/s] a period to all rotors and winds them
/// down. The motors are stopped on every way out. Errors: a command that is not finite or beyond
/// max_speed_radps, boards that do not answer or start in time, a line that is lost, an emergency of a board,
/// a board that tells other gains than it was sent.
Result<BenchRecord> run_motor_bench(Gateway& gateway, std::size_t rotors,
                                    std::span<const double> command_radps, const BenchConfig& config,
                                    const BenchClock& clock);

}  // namespace omniflight::gateway
