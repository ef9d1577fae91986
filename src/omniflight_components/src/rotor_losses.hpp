// Rotors that are lost in flight: noticed by their speeds, left out of the allocation, and whether the others
// can hover. Time is an argument; no bus inside.
#pragma once

#include <atomic>
#include <cmath>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "omniflight_allocation/allocator.hpp"
#include "omniflight_safety/rotor_watch.hpp"

namespace omniflight::components {

class RotorLosses {
 public:
  explicit RotorLosses(const vehicle::Vehicle& vehicle);

  /// Measured speeds [rad/s] at t [s]; from any thread. Kept until update() is `kLate` past them, so that
  /// what a period sees of them does not depend on the order in which topics arrive.
  void measured(double t, std::span<const double> speed);

  /// The rotors are wound down: they do not follow their commands any more. From any thread.
  void wind_down() { winds_down_ = true; }

  /// Whether the gate lets commands through from t [s] on; from any thread. While it does not it slows the
  /// rotors down, and samples of that time are not compared with commands that the rotors never got. Without
  /// a gate, in lockstep, every command gets through.
  void gate(double t, bool passes);

  /// Speeds [rad/s] and tilt [rad] that are sent to the rotors.
  void commanded(std::span<const double> speed, double alpha);

  /// Once a period: drops rotors from the allocator that turned out to be lost, and answers words about them,
  /// empty where there is nothing new. q_WR: the attitude that is asked for. trajectory_time [s] stands still
  /// while a vehicle is held or on the ground, where rotors do not follow commands.
  std::string update(double now_s, double trajectory_time, const Quat& q_WR,
                     allocation::Allocator& allocator);

  std::uint32_t lost() const { return watch_.lost(); }
  /// Share of their range that the others need to hover; 0 while none is lost, infinite where they cannot.
  double hover_load() const { return hover_load_; }

 private:
  static constexpr double kLate = 0.01;   // s
  static constexpr double kFlying = 1.0;  // s of moving trajectory time after which rotors follow commands
  // s of a closed gate, which slows rotors down to nothing in 0.5 s, after which they may be slow
  static constexpr double kFaded = 0.1;
  struct Sample {
    double t;
    std::vector<double> speed;
  };
  bool got_commands(double t) const;  ///< at t [s]; under mutex_
  std::string drop(std::uint32_t fresh, const Quat& q_WR, allocation::Allocator& allocator);

  vehicle::Vehicle vehicle_;
  safety::RotorWatch watch_;
  std::mutex mutex_;  ///< guards everything up to gate_passed_s_
  std::deque<Sample> samples_;
  bool gate_passes_ = true;
  double gate_closed_s_ = 0;          ///< since when it does not pass
  double gate_passed_s_ = -HUGE_VAL;  ///< s, since when it passes after it had not for longer than kFaded
  std::atomic<bool> winds_down_{false};
  std::vector<double> command_;
  double alpha_ = 0, hover_load_ = 0;
  double last_s_ = -1, last_along_ = 0, moving_s_ = 0;
};

/// Share of their range that the rotors of a vehicle without the `lost` ones (bits) need to hover: at q_WB
/// where their forces and torques are independent, else with their thrust axis upright. Infinite where
/// torques are not.
double hover_load_without(const vehicle::Vehicle& vehicle, std::uint32_t lost, double alpha,
                          const Quat& q_WB);

}  // namespace omniflight::components
