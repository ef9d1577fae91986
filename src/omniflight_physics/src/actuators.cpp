#include "omniflight_physics/actuators.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::physics {
namespace {

std::string in_seconds(double value) { return std::to_string(value) + " s"; }

std::uint64_t whole_steps(double duration, double step) {
  return static_cast<std::uint64_t>(std::llround(std::max(0.0, duration) / step));
}

vehicle::Tilt servo_of(const vehicle::Vehicle& vehicle, const Actuation& actuation) {
  vehicle::Tilt servo = vehicle.tilt;
  servo.time_constant = actuation.tilt_time_constant;
  servo.backlash = actuation.tilt_backlash;
  return servo;
}

}  // namespace

Actuation nominal_actuation(const vehicle::Vehicle& vehicle) {
  Actuation out;
  for (const vehicle::Rotor& rotor : vehicle.rotors) {
    out.time_constant.push_back(rotor.time_constant);
    out.delay.push_back(0.0);
  }
  out.tilt_time_constant = vehicle.tilt.time_constant;
  out.tilt_backlash = vehicle.tilt.backlash;
  return out;
}

Result<Actuators> Actuators::create(const vehicle::Vehicle& vehicle, Actuation a, double step,
                                    double initial_alpha) {
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    const double tau = a.time_constant.at(i), delay = a.delay.at(i);
    const std::string rotor = "rotor " + std::to_string(i + 1);
    if (!(tau >= 0 && tau <= 10))
      return bad_input("time constant of " + rotor + " is " + in_seconds(tau) + ", outside [0, 10] s",
                       "motor_lag");
    if (tau > 0 && step > 1.5 * tau)
      return bad_input("step of " + in_seconds(step) + " does not resolve the time constant of " + rotor +
                           ", " + in_seconds(tau),
                       "simulator.step_s", "Take a step of at most the time constant");
    if (!(delay >= 0 && delay <= 1.0))
      return bad_input("delay of " + rotor + " is " + in_seconds(delay) + ", outside [0, 1] s",
                       "transport_delay");
  }
  if (!(a.battery_voltage > 0))
    return bad_input("open-circuit voltage of " + std::to_string(a.battery_voltage) + " V is not positive",
                     "battery_sag.voltage");
  if (!(a.speed_limit_scale > 0 && a.slew_limit > 0))
    return bad_input("leaves no speed or no acceleration to the rotors", "actuator_saturation");
  return Actuators(vehicle, std::move(a), step, initial_alpha);
}

Actuators::Actuators(const vehicle::Vehicle& vehicle, Actuation actuation, double step, double initial_alpha)
    : vehicle_(vehicle),
      count_(vehicle.rotors.size()),
      actuation_(std::move(actuation)),
      step_(step),
      gains_(actuation_.wrench_gain != Vec6::Ones()),
      battery_(actuation_.battery_resistance != 0 || actuation_.battery_drop != 0),
      period_steps_(std::max<std::uint64_t>(1, whole_steps(actuation_.command_period, step))),
      dwell_steps_(whole_steps(actuation_.reversal_dwell, step)),
      servo_(servo_of(vehicle_, actuation_), initial_alpha),
      voltage_(actuation_.battery_voltage) {
  for (std::size_t i = 0; i < count_; ++i) {
    if (const double tau = actuation_.time_constant[i]; tau > 0) {
      inverse_lag_[i] = 1.0 / tau;
      share_middle_[i] = -std::expm1(-0.5 * step / tau);
      share_end_[i] = -std::expm1(-step / tau);
    }
    largest_[i] = vehicle_.rotors[i].max_speed() * actuation_.speed_limit_scale;
  }
  std::size_t longest = 0;
  for (const double delay : actuation_.delay) {
    delay_steps_.push_back(whole_steps(delay, step));
    longest = std::max(longest, delay_steps_.back());
  }
  history_.assign(longest + 1, {});
  plain_ = longest == 0 && !gains_ && !battery_ && period_steps_ == 1 && dwell_steps_ == 0 &&
           actuation_.dead_speed <= 0 && !(actuation_.command_step > 0);
}

void Actuators::reach_limited(const double* speed, double* middle, double* end) const {
  const double most = actuation_.slew_limit;
  for (std::size_t i = 0; i < count_; ++i) {
    const double tau = actuation_.time_constant[i], change = target_[i] - speed[i];
    const auto after = [&](double time) {
      if (tau <= 0) return speed[i];
      // at the limit until the lag asks for less
      const double limited = std::max(0.0, std::abs(change) / most - tau), at_limit = std::min(time, limited);
      const double reached = speed[i] + std::copysign(most * at_limit, change);
      return reached - std::expm1(-(time - at_limit) / tau) * (target_[i] - reached);
    };
    middle[i] = after(0.5 * step_);
    end[i] = after(step_);
  }
}

void Actuators::change_wrench(Speeds& command) const {
  const vehicle::AllocationMatrix A = vehicle_.allocation_matrix(alpha());
  vehicle::RotorVector thrust(static_cast<Eigen::Index>(count()));
  for (std::size_t i = 0; i < count(); ++i)
    thrust[static_cast<Eigen::Index>(i)] = vehicle_.rotors[i].thrust(command[i]);
  const Vec6 wrench = A.lazyProduct(thrust);
  const Vec6 change = (actuation_.wrench_gain - Vec6::Ones()).cwiseProduct(wrench);
  Mat6 gram = A.lazyProduct(A.transpose());
  gram.diagonal().array() += 1e-9 * gram.trace();  // a vehicle that cannot push sideways has rank four
  const Vec6 dual = gram.ldlt().solve(change);
  for (std::size_t i = 0; i < count(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const vehicle::Rotor& r = vehicle_.rotors[i];
    const double T = thrust[k] + A.col(k).dot(dual);
    command[i] = r.speed(std::clamp(T, r.bidirectional ? -r.max_thrust : 0.0, r.max_thrust));
  }
}

double Actuators::battery_factor(double mechanical_power) {
  if (!battery_) return 1.0;
  const double open = std::max(1.0, actuation_.battery_voltage - actuation_.battery_drop * energy_);
  const double electrical = mechanical_power / actuation_.drive_efficiency;
  voltage_ =
      std::max(0.1 * actuation_.battery_voltage, open - actuation_.battery_resistance * electrical / open);
  energy_ += electrical * step_;
  return voltage_ / actuation_.battery_voltage;
}

void Actuators::begin_step(std::span<const double> command, double alpha_command, double mechanical_power) {
  servo_.step(alpha_command, step_);
  if (plain_) {
    for (std::size_t i = 0; i < count(); ++i)
      target_[i] = std::min(std::max(command[i], -largest_[i]), largest_[i]);
    ++steps_;
    return;
  }
  if (steps_ % period_steps_ == 0) {
    std::copy_n(command.begin(), count(), taken_.begin());
    if (gains_) change_wrench(taken_);
    if (const double q = actuation_.command_step; q > 0)
      for (std::size_t i = 0; i < count(); ++i) taken_[i] = q * std::round(taken_[i] / q);
  }
  const std::size_t slots = history_.size(), newest = slots == 1 ? 0 : steps_ % slots;
  history_[newest] = taken_;
  const double factor = battery_factor(mechanical_power);
  for (std::size_t i = 0; i < count(); ++i) {
    const std::size_t back = delay_steps_[i];
    double wanted = back > steps_ ? 0.0 : history_[newest >= back ? newest - back : newest + slots - back][i];
    if (std::abs(wanted) < actuation_.dead_speed) wanted = 0.0;
    if (dwell_steps_ > 0) {
      if (wanted * direction_[i] < 0) rests_until_[i] = steps_ + dwell_steps_;
      if (wanted != 0) direction_[i] = wanted > 0 ? 1.0 : -1.0;
      if (steps_ < rests_until_[i]) wanted = 0.0;
    }
    wanted *= 1.0 - actuation_.open_loop * (1.0 - factor);
    const double limit = largest_[i] * factor;
    target_[i] = std::clamp(wanted, -limit, limit);
  }
  ++steps_;
}

}  // namespace omniflight::physics
