#include "omniflight_gateway/bench_motors.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::gateway {

BenchMotors::BenchMotors(const BenchMotorConfig& config)
    : config_(config),
      random_(config.seed, "bench motors"),
      targets_(config.rotors, 0.0),
      loops_(config.rotors, Loop{config.gains}),
      speeds_(config.rotors, 0.0) {
  commands_.push_back({-1e18, speeds_});
}

void BenchMotors::set_command(std::span<const double> speeds) {
  targets_.assign(speeds.begin(), speeds.end());
  targets_.resize(config_.rotors, 0.0);
  if (!config_.speed_loop && targets_ != commands_.back().speeds)
    commands_.push_back({now_s_ + config_.delay_s, targets_});
}

void BenchMotors::take_gains(BoardEmulator& emulator) {
  for (std::size_t i = 0; i < emulator.board_count(); ++i) {
    const EmulatedBoard& board = emulator.board(i);
    for (std::size_t k = 0; k < board.config().rotors; ++k) {
      const std::size_t rotor = board.config().rotor_offset + k;
      const auto& sent = board.gains(k);
      if (!sent || rotor >= loops_.size()) continue;
      loops_[rotor].gains = {sent->kp / kPidScale, sent->ki / kPidScale, sent->kd / kPidScale,
                             sent->f / kPidScale};
    }
  }
}

double BenchMotors::measured(std::size_t k) {
  return speeds_[k] == 0 ? 0.0 : speeds_[k] + config_.noise_radps * random_.normal();
}

void BenchMotors::close_loops() {
  Command command{now_s_ + config_.delay_s, std::vector<double>(loops_.size())};
  const double T = config_.loop_period_s;
  for (std::size_t k = 0; k < loops_.size(); ++k) {
    Loop& l = loops_[k];
    if (targets_[k] == 0) {
      l = Loop{l.gains};
      continue;
    }
    const double error = (targets_[k] - measured(k)) / (2 * kPi), more = l.gains.ki * T * error;
    const double filter = 1000 * l.gains.f;
    if (filter > 0) l.filtered = (l.filtered + l.gains.kd * filter * (error - l.before)) / (1 + filter * T);
    l.before = error;
    const double wanted = l.gains.kp * error + l.integral + more + l.filtered;
    l.throttle = std::clamp(wanted, -1.0, 1.0);
    if (wanted == l.throttle || more * wanted < 0) l.integral += more;  // stands still at the limits
    command.speeds[k] = l.throttle * config_.full_speed_radps;
  }
  commands_.push_back(std::move(command));
}

void BenchMotors::step(double now_s) {
  if (!stepped_) {
    now_s_ = started_s_ = loop_due_s_ = now_s;
    stepped_ = true;
  }
  while (now_s_ < now_s) {
    if (config_.speed_loop && now_s_ >= loop_due_s_ - 1e-9) {
      close_loops();
      loop_due_s_ += config_.loop_period_s;
    }
    while (commands_.size() > 1 && commands_[1].since_s <= now_s_ + 1e-12) commands_.pop_front();
    double until = commands_.size() > 1 ? std::min(now_s, commands_[1].since_s) : now_s;
    if (config_.speed_loop) until = std::min(until, loop_due_s_);
    for (std::size_t k = 0; k < speeds_.size(); ++k) {
      const double target = commands_.front().speeds[k];
      const double lag = std::abs(target) > std::abs(speeds_[k]) ? config_.lag_up_s : config_.lag_down_s;
      speeds_[k] = target + (speeds_[k] - target) * std::exp(-(until - now_s_) / lag);
    }
    now_s_ = until;
  }
}

PlantSample BenchMotors::sample() {
  PlantSample out;
  out.rotor_speed_radps.resize(speeds_.size());
  for (std::size_t k = 0; k < speeds_.size(); ++k) out.rotor_speed_radps[k] = measured(k);
  out.rotor_current_A.assign(speeds_.size(), 0.5);
  if (config_.speed_loop)
    for (const Loop& l : loops_) out.rotor_throttle.push_back(l.throttle);
  out.battery_V = config_.battery_V - config_.sag_V_per_s * (now_s_ - started_s_);
  return out;
}

}  // namespace omniflight::gateway
