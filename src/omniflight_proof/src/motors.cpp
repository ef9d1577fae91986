#include "motors.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::proof {
namespace {

Drive nominal(const vehicle::Rotor& r) {
  Drive d{};
  d.reference_speed = 0.5 * r.max_speed();
  d.thrust_forward = d.thrust_reverse = r.thrust_coefficient * d.reference_speed * d.reference_speed;
  d.exponent = 2;
  d.drag_ratio = r.drag_ratio;
  d.time_constant = r.time_constant;
  d.slowing_factor = 1;
  d.max_speed = r.max_speed();
  d.axis_B = r.axis_B;
  d.tilt_axis_B = r.tilt_axis_B;
  d.p_B = r.p_BR;
  d.tilts = r.tilts;
  d.bidirectional = r.bidirectional;
  d.spin = r.spin;
  d.fails_from = d.fails_until = -1;
  return d;
}

void change(Drive& d, const RotorChange& c, double timestep) {
  d.thrust_forward *= c.thrust_scale;
  d.thrust_reverse *= c.thrust_scale * c.reverse_scale;
  d.drag_ratio *= c.drag_torque_scale;
  if (c.exponent != 2) d.exponent = c.exponent;
  if (c.time_constant >= 0) d.time_constant = c.time_constant;
  d.slowing_factor *= c.slowing_factor;
  d.delay_steps += static_cast<std::size_t>(std::llround(c.delay / timestep));
  if (c.dead_speed > 0) d.dead_speed = c.dead_speed;
  if (c.max_speed > 0) d.max_speed = std::min(d.max_speed, c.max_speed);
  if (c.quantum > 0) d.quantum = c.quantum;
  d.inertia += c.inertia;
  const Quat turn = exp_rotation(c.axis_tilt_B);
  d.axis_B = turn * d.axis_B;
  d.tilt_axis_B = turn * d.tilt_axis_B;
  d.p_B += c.shift_B;
  if (c.linear_share != 0) d.linear_share = c.linear_share;
  if (c.drag_exponent != 0) d.drag_exponent = c.drag_exponent;
  d.lean_B += c.lean_B;
  if (c.slew > 0) d.slew = d.slew > 0 ? std::min(d.slew, c.slew) : c.slew;
  if (c.hold > 0) d.hold = c.hold;
  if (c.restart > 0) d.restart = c.restart;
  if (c.thrust_lag > 0) {
    d.thrust_lag = c.thrust_lag;
    d.thrust_lead = c.thrust_lead;
  }
  if (c.fails_from >= 0) {
    d.fails_from = c.fails_from;
    d.fails_until = c.fails_until >= 0 ? c.fails_until : 1e300;
  }
}

}  // namespace

double Drive::thrust(double speed) const {
  const double ratio = std::abs(speed) / reference_speed;
  const double power = exponent == 2 ? ratio * ratio : std::pow(ratio, exponent);
  const double shape = power + linear_share * (ratio - power);
  return speed < 0 && bidirectional ? -thrust_reverse * shape : thrust_forward * shape;
}

double Drive::drag_ratio_at(double speed) const {
  if (drag_exponent == 0) return drag_ratio;
  return drag_ratio * std::pow(std::max(0.05, std::abs(speed) / reference_speed), drag_exponent);
}

Motors::Motors(const vehicle::Vehicle& vehicle, const World& world, double timestep, double alpha)
    : tilt_(vehicle.tilt), tilt_change_(world.tilt), battery_(world.battery) {
  for (const auto& rotor : vehicle.rotors) drives_.push_back(nominal(rotor));
  for (const RotorChange& c : world.rotors)
    for (std::size_t i = 0; i < drives_.size(); ++i)
      if (c.rotor == 0 || c.rotor == static_cast<int>(i) + 1) change(drives_[i], c, timestep);
  std::size_t longest = 0;
  for (const Drive& d : drives_) longest = std::max(longest, d.delay_steps);
  history_.assign(longest + 1, {});
  reset(alpha);
}

void Motors::reset(double alpha) {
  speed_ = acceleration_ = command_ = held_ = thrust_ = settled_ = {};
  stands_until_.fill(-1);
  std::fill(history_.begin(), history_.end(), PerRotor{});
  steps_ = 0;
  alpha_ = alpha_command_ = alpha_told_ = alpha_servo_ = alpha;
  alpha_true_ = alpha + tilt_change_.offset;
  energy_ = polarisation_ = current_ = 0;
  voltage_ = battery_ ? battery_->nominal : 0;
}

bool Motors::command(std::span<const double> speed, double alpha) {
  if (speed.size() != count() || !std::isfinite(alpha)) return false;
  if (!std::all_of(speed.begin(), speed.end(), [](double s) { return std::isfinite(s); })) return false;
  std::copy(speed.begin(), speed.end(), command_.begin());
  alpha_command_ = tilt_.kind == vehicle::TiltKind::none ? 0.0 : std::clamp(alpha, tilt_.min, tilt_.max);
  return true;
}

double Motors::goal(std::size_t i, double command, double t) {
  const Drive& d = drives_[i];
  if (t >= d.fails_from && t < d.fails_until) return 0;
  if (d.quantum > 0) command = d.quantum * std::round(command / d.quantum);
  if (d.restart > 0) {
    if (std::abs(command) < d.dead_speed || command * speed_[i] < 0)
      stands_until_[i] = std::max(stands_until_[i], t + d.restart);
    if (t < stands_until_[i] && std::abs(speed_[i]) < 2 * d.dead_speed + 1) return 0;
  }
  if (std::abs(command) < d.dead_speed) return 0;
  command = std::clamp(command, d.bidirectional ? -d.max_speed : 0.0, d.max_speed);
  if (battery_) command *= std::pow(std::max(0.0, voltage_ / battery_->nominal), battery_->sensitivity);
  return command;
}

void Motors::step(double t, double h) {
  history_[steps_ % history_.size()] = command_;
  for (std::size_t i = 0; i < count(); ++i) {
    const Drive& d = drives_[i];
    double asked = steps_ >= d.delay_steps ? history_[(steps_ - d.delay_steps) % history_.size()][i] : 0.0;
    if (d.hold > 0) {
      const auto every = static_cast<std::size_t>(std::max(1.0, std::round(d.hold / h)));
      if (steps_ % every == 0) held_[i] = asked;
      asked = held_[i];
    }
    const double wanted = goal(i, asked, t);
    double tau = d.time_constant;
    if (std::abs(wanted) < std::abs(speed_[i])) tau *= d.slowing_factor;
    double next = tau > 0 ? wanted + (speed_[i] - wanted) * std::exp(-h / tau) : wanted;
    if (d.slew > 0) next = std::clamp(next, speed_[i] - d.slew * h, speed_[i] + d.slew * h);
    acceleration_[i] = tau > 0 ? (next - speed_[i]) / h : 0.0;
    speed_[i] = next;
  }
  ++steps_;

  step_tilt(h);
  step_thrust(h);
  step_battery(h);
}

void Motors::step_tilt(double h) {
  // as the vehicle file tells it, which the servo reports
  const double most = tilt_.rate > 0 ? tilt_.rate * tilt_change_.rate_scale * h : 1e300;
  double way = alpha_command_ - alpha_told_;
  if (tilt_.time_constant > 0) way -= way * std::exp(-h / tilt_.time_constant);
  alpha_told_ += std::clamp(way, -most, most);
  alpha_ = std::clamp(alpha_, alpha_told_ - 0.5 * tilt_.backlash, alpha_told_ + 0.5 * tilt_.backlash);
  // and what is hidden, which it does not
  const double lag = tilt_change_.time_constant;
  alpha_servo_ = lag > 0 ? alpha_ + (alpha_servo_ - alpha_) * std::exp(-h / lag) : alpha_;
  const double driven = alpha_servo_ + tilt_change_.offset, play = 0.5 * tilt_change_.backlash;
  alpha_true_ = std::clamp(alpha_true_, driven - play, driven + play);
}

void Motors::step_thrust(double h) {
  for (std::size_t i = 0; i < count(); ++i) {
    const Drive& d = drives_[i];
    const double now = d.thrust(speed_[i]);
    settled_[i] = d.thrust_lag > 0 ? now + (settled_[i] - now) * std::exp(-h / d.thrust_lag) : now;
    thrust_[i] = now + d.thrust_lead * (now - settled_[i]);
  }
  const TiltChange& c = tilt_change_;
  efficiency_ = 1;
  if (c.loss == 0) return;
  const double off = c.loss_width > 0 ? (alpha_true_ - c.loss_center) / c.loss_width : 0;
  efficiency_ -= c.loss * (c.loss_width > 0 ? std::exp(-off * off) : 1 - alpha_true_ / to_radians(60));
}

double Motors::electrical_power() const {
  double power = 0;
  for (std::size_t i = 0; i < count(); ++i)
    power += std::abs(drives_[i].drag_ratio * drives_[i].thrust(speed_[i]) * speed_[i]);
  return power / (battery_ ? battery_->efficiency : 1.0);
}

void Motors::step_battery(double h) {
  if (!battery_) return;
  const BatterySag& b = *battery_;
  const double power = electrical_power();
  current_ = power / std::max(0.3 * b.nominal, voltage_);
  energy_ += power * h;
  polarisation_ += (b.polarisation * current_ - polarisation_) * (1 - std::exp(-h / b.polarisation_time));
  voltage_ = std::max(0.0, b.nominal - b.drop * energy_ - b.resistance * current_ - polarisation_);
}

Vec3 Motors::axis_B(std::size_t i) const {
  const Drive& d = drives_[i];
  const Vec3 axis = d.tilts ? Vec3(Eigen::AngleAxisd(alpha_true_, d.tilt_axis_B) * d.axis_B) : d.axis_B;
  return d.lean_B.isZero() ? axis : Vec3(exp_rotation(d.lean_B * thrust_[i]) * axis);
}

}  // namespace omniflight::proof
