#include "omniflight_gateway/bench_motors.hpp"

#include <cmath>

namespace omniflight::gateway {

BenchMotors::BenchMotors(const BenchMotorConfig& config)
    : config_(config), random_(config.seed, "bench motors"), speeds_(config.rotors, 0.0) {
  commands_.push_back({-1e18, speeds_});
}

void BenchMotors::set_command(std::span<const double> speeds) {
  Command command{now_s_ + config_.delay_s, std::vector<double>(speeds.begin(), speeds.end())};
  command.speeds.resize(config_.rotors, 0.0);
  if (command.speeds != commands_.back().speeds) commands_.push_back(std::move(command));
}

void BenchMotors::step(double now_s) {
  if (!stepped_) {
    now_s_ = started_s_ = now_s;
    stepped_ = true;
  }
  while (now_s_ < now_s) {
    while (commands_.size() > 1 && commands_[1].since_s <= now_s_ + 1e-12) commands_.pop_front();
    const double until = commands_.size() > 1 ? std::min(now_s, commands_[1].since_s) : now_s;
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
  out.rotor_speed_radps = speeds_;
  for (double& speed : out.rotor_speed_radps)
    if (speed != 0) speed += config_.noise_radps * random_.normal();
  out.rotor_current_A.assign(speeds_.size(), 0.5);
  out.battery_V = config_.battery_V - config_.sag_V_per_s * (now_s_ - started_s_);
  return out;
}

}  // namespace omniflight::gateway
