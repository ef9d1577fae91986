// Rotors and tilt servo between command and motion, with every alteration of an Actuation carried out.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/actuation.hpp"
#include "omniflight_physics/tilt_servo.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::physics {

/// The drive as the vehicle file tells it, before any effect alters it: lags of the rotors, lag and play of
/// the tilt servo.
Actuation nominal_actuation(const vehicle::Vehicle& vehicle);

/// One drive train, stepped at a fixed period. Allocates in the constructor only; deterministic.
class Actuators {
 public:
  /// Refuses delays and lags that are negative, not finite, or not resolved by the step [s].
  static Result<Actuators> create(const vehicle::Vehicle& vehicle, Actuation actuation, double step,
                                  double initial_alpha);

  /// Start of a step: rotor speed commands [rad/s, signed], tilt command [rad], mechanical power of the
  /// rotors over the last step [W]. Sets target() and alpha() for the step.
  void begin_step(std::span<const double> command, double alpha_command, double mechanical_power);

  /// Speed [rad/s] a rotor strives for during this step.
  double target(std::size_t rotor) const { return target_[rotor]; }
  /// dOmega/dt [rad/s^2] at a speed [rad/s]; zero for a rotor without lag, whose speed follows() at once.
  double rate(std::size_t rotor, double speed) const {
    const double rate = (target_[rotor] - speed) * inverse_lag_[rotor];
    return std::clamp(rate, -actuation_.slew_limit, actuation_.slew_limit);
  }
  /// The same of all rotors.
  void rates(const double* speed, double* out) const {
    const double most = actuation_.slew_limit;
    for (std::size_t i = 0; i < count_; ++i)
      out[i] = std::min(std::max((target_[i] - speed[i]) * inverse_lag_[i], -most), most);
  }
  /// Speeds [rad/s] of all rotors half a step and a whole step after `speed`: the exact answer of the lag
  /// (and of a limited acceleration) to a target that rests during the step.
  void reach(const double* speed, double* middle, double* end) const {
    if (std::isfinite(actuation_.slew_limit)) return reach_limited(speed, middle, end);
    for (std::size_t i = 0; i < count_; ++i) {
      const double change = target_[i] - speed[i];
      middle[i] = speed[i] + share_middle_[i] * change;
      end[i] = speed[i] + share_end_[i] * change;
    }
  }
  /// Share of its way to the target that a rotor comes in half a step and in a whole one; zero without lag.
  double share_middle(std::size_t rotor) const { return share_middle_[rotor]; }
  double share_end(std::size_t rotor) const { return share_end_[rotor]; }
  /// Speed [rad/s] during the step of a rotor without lag that had `speed` before it; others keep theirs.
  double follows(std::size_t rotor, double speed) const {
    if (actuation_.time_constant[rotor] > 0) return speed;
    const double most = actuation_.slew_limit * step_;
    return speed + most > target_[rotor] && speed - most < target_[rotor]
               ? target_[rotor]
               : speed + std::clamp(target_[rotor] - speed, -most, most);
  }
  double alpha() const { return servo_.alpha(); }  ///< rad, of the rotors
  double voltage() const { return voltage_; }      ///< V, at the battery's terminals
  double energy() const { return energy_; }        ///< J drawn from the battery
  const Actuation& actuation() const { return actuation_; }

 private:
  Actuators(const vehicle::Vehicle& vehicle, Actuation actuation, double step, double initial_alpha);
  using Speeds = std::array<double, vehicle::kMaxRotors>;
  std::size_t count() const { return count_; }
  void change_wrench(Speeds& command) const;
  void reach_limited(const double* speed, double* middle, double* end) const;
  double battery_factor(double mechanical_power);

  vehicle::Vehicle vehicle_;
  std::size_t count_;  ///< of rotors
  Actuation actuation_;
  double step_;
  bool gains_ = false, battery_ = false;
  bool plain_ = false;  ///< nothing but limits and lags
  std::uint64_t steps_ = 0, period_steps_ = 1, dwell_steps_ = 0;
  std::vector<Speeds> history_;  ///< commands of past steps, a ring
  std::vector<std::size_t> delay_steps_;
  Speeds taken_{}, target_{}, direction_{};
  Speeds inverse_lag_{};  ///< 1/s, zero of a rotor without lag
  Speeds share_middle_{}, share_end_{};
  Speeds largest_{};  ///< rad/s, commanded speed at full voltage
  std::array<std::uint64_t, vehicle::kMaxRotors> rests_until_{};
  TiltServo servo_;
  double voltage_ = 0, energy_ = 0;
};

}  // namespace omniflight::physics
