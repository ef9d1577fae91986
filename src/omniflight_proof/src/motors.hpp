// Speed controllers, motors and tilt servo: from commands to speeds and the angle of the axes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "omniflight_proof/world.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

using PerRotor = std::array<double, vehicle::kMaxRotors>;

/// A rotor after all RotorChanges.
struct Drive {
  double thrust_forward, thrust_reverse;  ///< N at reference speed
  double reference_speed, exponent;       ///< thrust = thrust_* (|speed| / reference)^exponent
  double drag_ratio;                      ///< m
  double time_constant, slowing_factor, max_speed, dead_speed, quantum, inertia;
  std::size_t delay_steps;
  Vec3 axis_B, tilt_axis_B, p_B;
  bool tilts, bidirectional;
  int spin;
  double fails_from, fails_until;
  double linear_share = 0, drag_exponent = 0, slew = 0, hold = 0, restart = 0, thrust_lag = 0,
         thrust_lead = -1;
  Vec3 lean_B = Vec3::Zero();  ///< rad/N

  double thrust(double speed) const;         ///< N along the axis, signed
  double drag_ratio_at(double speed) const;  ///< m
};

class Motors {
 public:
  Motors(const vehicle::Vehicle& vehicle, const World& world, double timestep, double alpha);
  void reset(double alpha);
  bool command(std::span<const double> speed, double alpha);
  /// One time step h that ends at time t.
  void step(double t, double h);
  /// Electrical load for the battery [W].
  double electrical_power() const;

  std::size_t count() const { return drives_.size(); }
  const Drive& drive(std::size_t i) const { return drives_[i]; }
  const PerRotor& speed() const { return speed_; }                ///< rad/s
  const PerRotor& acceleration() const { return acceleration_; }  ///< rad/s^2
  double alpha_reported() const { return alpha_; }
  double alpha_true() const { return alpha_true_; }
  /// N along the axis in still air: with its lag, and less what is lost at this tilt.
  double thrust(std::size_t i) const { return efficiency_ * thrust_[i]; }
  Vec3 axis_B(std::size_t i) const;  ///< unit thrust axis now
  double battery_voltage() const { return voltage_; }
  double battery_current() const { return current_; }

 private:
  void step_battery(double h);
  double goal(std::size_t i, double command, double t);
  void step_tilt(double h);
  void step_thrust(double h);

  vehicle::Tilt tilt_;
  TiltChange tilt_change_;
  std::optional<BatterySag> battery_;
  std::vector<Drive> drives_;
  PerRotor speed_{}, acceleration_{};
  std::vector<PerRotor> history_;
  PerRotor command_{}, held_{}, stands_until_{}, thrust_{}, settled_{};
  double efficiency_ = 1;
  std::size_t steps_ = 0;
  double alpha_ = 0, alpha_command_ = 0, alpha_told_ = 0, alpha_servo_ = 0, alpha_true_ = 0;
  double energy_ = 0, polarisation_ = 0, voltage_ = 0, current_ = 0;
};

}  // namespace omniflight::proof
