#include "omniflight_simulation/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_core/half_period.hpp"

namespace omniflight::simulation {

SensorConfig read_sensor_config(files::YamlReader yaml) {
  using files::between, files::non_negative, files::any_number;
  SensorConfig c;
  c.imu_rate = yaml.number("imu_rate_hz", between(1, 8000, "Hz"), c.imu_rate);
  c.accelerometer_noise =
      yaml.number("accelerometer_noise_mps2", between(0, 10, "m/s2"), c.accelerometer_noise);
  c.accelerometer_bias = yaml.vec3("accelerometer_bias_mps2", between(-5, 5, "m/s2"), c.accelerometer_bias);
  c.gyro_noise = yaml.number("gyro_noise_radps", between(0, 5, "rad/s"), c.gyro_noise);
  c.gyro_bias = yaml.vec3("gyro_bias_radps", between(-1, 1, "rad/s"), c.gyro_bias);
  c.mocap_rate = yaml.number("mocap_rate_hz", between(1, 1000, "Hz"), c.mocap_rate);
  c.mocap_position_noise =
      yaml.number("mocap_position_noise_m", between(0, 0.1, "m"), c.mocap_position_noise);
  c.mocap_attitude_noise =
      yaml.number("mocap_attitude_noise_rad", between(0, 0.2, "rad"), c.mocap_attitude_noise);
  c.mocap_latency = yaml.number("mocap_latency_s", between(0, 0.2, "s"), c.mocap_latency);
  c.mocap_dropout = yaml.number("mocap_dropout", between(0, 0.9, "1"), c.mocap_dropout);
  c.rotor_rate = yaml.number("rotor_rate_hz", between(1, 4000, "Hz"), c.rotor_rate);
  c.rotor_noise = yaml.number("rotor_noise_radps", between(0, 50, "rad/s"), c.rotor_noise);
  c.half_period_quantisation = yaml.boolean("half_period_quantisation", c.half_period_quantisation);
  c.battery_rate = yaml.number("battery_rate_hz", between(0.1, 100, "Hz"), c.battery_rate);
  c.battery_voltage = yaml.number("battery_voltage_V", between(1, 100, "V"), c.battery_voltage);
  c.battery_resistance = yaml.number("battery_resistance_ohm", non_negative("ohm"), c.battery_resistance);
  c.battery_sag = yaml.number("battery_sag_V_per_J", non_negative("V/J"), c.battery_sag);
  c.drive_efficiency = yaml.number("drive_efficiency", between(0.05, 1, "1"), c.drive_efficiency);
  return c;
}

SensorSuite::SensorSuite(const SensorConfig& config, const physics::Model& model, double step,
                         std::uint64_t seed)
    : config_(config),
      step_(step),
      imu_rng_(seed, "imu"),
      mocap_rng_(seed, "mocap"),
      rotor_rng_(seed, "rotor") {
  for (const auto& e : model.effects) e.effect->alter_sensing(e.theta.data(), sensing_);
  sensing_.accelerometer_bias += config.accelerometer_bias;
  sensing_.gyro_bias += config.gyro_bias;
  in_flight_.resize(static_cast<std::size_t>(config.mocap_latency * config.mocap_rate) + 4);
}

bool SensorSuite::due(double rate) const {
  const auto period = static_cast<std::uint64_t>(std::max(1.0, std::round(1.0 / (rate * step_))));
  return count_ % period == 0;
}

void SensorSuite::sample(const Plant& plant, SensorFrame& frame) {
  frame.imu = frame.mocap = frame.rotor = frame.battery = false;
  const double t = plant.time();
  const double electrical = plant.mechanical_power() / config_.drive_efficiency;
  if (count_ > 0) energy_ += electrical * step_;
  if (due(config_.imu_rate)) {
    frame.imu = true;
    frame.imu_sample.t = t;
    const Vec3 f = plant.specific_force();
    frame.imu_sample.specific_force_B = f + sensing_.accelerometer_scale.cwiseProduct(f) +
                                        sensing_.accelerometer_bias +
                                        normal3(imu_rng_, config_.accelerometer_noise);
    frame.imu_sample.gyro_B =
        plant.body().w_WB_B + sensing_.gyro_bias + normal3(imu_rng_, config_.gyro_noise);
  }
  if (due(config_.mocap_rate)) {
    Delayed d;
    d.arrival = count_ + static_cast<std::uint64_t>(std::llround(config_.mocap_latency / step_));
    const Quat tilt = exp_rotation(sensing_.mocap_tilt);
    d.sample.t = t;
    d.sample.p_WB = tilt * plant.body().p_WB + normal3(mocap_rng_, config_.mocap_position_noise);
    d.sample.q_WB =
        tilt * plant.body().q_WB * exp_rotation(normal3(mocap_rng_, config_.mocap_attitude_noise));
    const bool dropped = mocap_rng_.uniform() < config_.mocap_dropout;
    if (!dropped) in_flight_[head_++ % in_flight_.size()] = d;
  }
  if (tail_ < head_ && in_flight_[tail_ % in_flight_.size()].arrival <= count_) {
    frame.mocap = true;
    frame.mocap_sample = in_flight_[tail_++ % in_flight_.size()].sample;
  }
  if (due(config_.rotor_rate)) {
    frame.rotor = true;
    frame.rotor_sample.t = t;
    frame.rotor_sample.alpha = plant.alpha();
    const auto speeds = plant.rotor_speed();
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      const double s = speeds[i] + config_.rotor_noise * rotor_rng_.normal();
      frame.rotor_sample.speed[i] =
          config_.half_period_quantisation ? speed_from_half_period(half_period_from_speed(s)) : s;
    }
  }
  if (due(config_.battery_rate)) {
    frame.battery = true;
    const double open = config_.battery_voltage - config_.battery_sag * energy_;
    const double current = electrical / std::max(1.0, open);
    frame.battery_sample = {t, open - config_.battery_resistance * current, current};
  }
  ++count_;
}

}  // namespace omniflight::simulation
