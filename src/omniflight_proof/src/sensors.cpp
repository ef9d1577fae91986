#include "omniflight_proof/sensors.hpp"

#include <cmath>

#include "omniflight_core/half_period.hpp"
#include "omniflight_proof/plant.hpp"

namespace omniflight::proof {

SensorSuite::SensorSuite(const SensorConfig& config, const SensorChange& change, double step,
                         std::uint64_t seed)
    : config_(config),
      change_(change),
      step_(step),
      accelerometer_{Random(seed, "proof accelerometer"), {}},
      gyro_{Random(seed, "proof gyro"), {}},
      position_{Random(seed, "proof mocap position"), {}},
      attitude_{Random(seed, "proof mocap attitude"), {}},
      speed_{Random(seed, "proof rotor speed"), {}},
      chance_imu_(seed, "proof imu dropout"),
      chance_mocap_(seed, "proof mocap dropout"),
      chance_rotor_(seed, "proof rotor dropout"),
      chance_repeat_(seed, "proof pose repeat"),
      walk_(seed, "proof bias walk"),
      jitter_(seed, "proof stamp jitter"),
      voltage_(seed, "proof battery") {
  const double latency = config.mocap_latency + change.mocap_extra_latency;
  in_flight_.resize(static_cast<std::size_t>(latency * config.mocap_rate) + 4);
}

bool SensorSuite::due(double rate) const {
  const auto period = static_cast<std::uint64_t>(std::max(1.0, std::round(1.0 / (rate * step_))));
  return count_ % period == 0;
}

double SensorSuite::draw(Noise& noise, std::size_t channel, double rms, double rate) {
  double white = noise.rng.normal();
  if (change_.outlier_share > 0 && noise.rng.uniform() < change_.outlier_share) white *= change_.outlier_size;
  const double time = change_.noise_correlation_time;
  if (time <= 0) return rms * white;
  const double keep = std::exp(-1.0 / (rate * time));
  noise.state[channel] = keep * noise.state[channel] + std::sqrt(1 - keep * keep) * white;
  return rms * noise.state[channel];
}

Vec3 SensorSuite::draw3(Noise& noise, double rms, double rate) {
  const double x = draw(noise, 0, rms, rate), y = draw(noise, 1, rms, rate);
  return {x, y, draw(noise, 2, rms, rate)};
}

const SensorFault* SensorSuite::fault(SensorFault::Sensor sensor, double t, int rotor) const {
  for (const SensorFault& f : change_.faults)
    if (f.sensor == sensor && t >= f.from && t < f.until && (f.rotor == 0 || rotor == 0 || f.rotor == rotor))
      return &f;
  return nullptr;
}

double SensorSuite::board_time(double t) const {
  const double skew = config_.board_clock_skew + change_.board_clock_skew;
  return std::max(0.0, (1 + skew) * t + config_.board_clock_offset + change_.board_clock_offset);
}

Vec3 SensorSuite::LowPass::operator()(const Vec3& input, double pass) {
  if (!begun) first = second = input;
  begun = true;
  first += pass * (input - first);
  second += pass * (first - second);
  return second;
}

void SensorSuite::imu(const MujocoPlant& plant, SensorFrame& frame) {
  const Vec3& w = plant.body().w_WB_B;
  const Vec3 r = config_.imu_position + change_.imu_p_B;
  Vec3 f = plant.specific_force() + plant.angular_acceleration().cross(r) + w.cross(w.cross(r));
  if (change_.vibration > 0) {
    for (std::size_t i = 0; i < plant.rotor_speed().size(); ++i) {
      const double speed = std::abs(plant.rotor_speed()[i]),
                   share = speed / plant.vehicle().rotors[i].max_speed();
      phase_[i] = std::fmod(phase_[i] + speed * step_, 2 * kPi);
      if (change_.vibration_rotor > 0 && change_.vibration_rotor != static_cast<int>(i) + 1) continue;
      f += change_.vibration * share * share * Vec3(std::cos(phase_[i]), std::sin(phase_[i]), 0);
    }
  }
  Vec3 gyro = w;
  const auto smooth = [&](int k, double cut_off, Vec3& value) {
    // two equal poles are 3 dB down together where each is 1.554 times lower
    if (cut_off > 0) value = filters_[k](value, 1 - std::exp(-2 * kPi * 1.554 * cut_off * step_));
  };
  smooth(0, config_.accelerometer_filter, f);
  smooth(1, config_.gyro_filter, gyro);
  smooth(2, change_.imu_low_pass, f);
  smooth(3, change_.imu_low_pass, gyro);
  const auto walk = [&](double density, Vec3& bias) {
    if (density > 0)
      bias += density * std::sqrt(step_) * Vec3(walk_.normal(), walk_.normal(), walk_.normal());
  };
  walk(config_.accelerometer_bias_walk, accelerometer_walk_);
  walk(config_.gyro_bias_walk, gyro_walk_);
  if (!due(config_.imu_rate)) return;
  const bool lost = chance_imu_.uniform() < change_.imu_dropout;
  ImuSample s;
  s.t = board_time(plant.time());
  const auto rms = [&](double sample, double density) {
    return std::hypot(sample, density * std::sqrt(0.5 * config_.imu_rate));
  };
  s.specific_force_B =
      f + (config_.accelerometer_scale + change_.accelerometer_scale).cwiseProduct(f) +
      config_.accelerometer_misalignment.cross(f) + config_.accelerometer_bias + change_.accelerometer_bias +
      accelerometer_walk_ +
      draw3(accelerometer_, rms(config_.accelerometer_noise, config_.accelerometer_noise_density),
            config_.imu_rate);
  s.gyro_B = gyro + (config_.gyro_scale + change_.gyro_scale).cwiseProduct(gyro) + config_.gyro_bias +
             change_.gyro_bias + gyro_walk_ +
             draw3(gyro_, rms(config_.gyro_noise, config_.gyro_noise_density), config_.imu_rate);
  if (const SensorFault* bad = fault(SensorFault::Sensor::imu, plant.time())) {
    if (bad->silent) return;
    if (bad->frozen) {
      s.specific_force_B = last_.imu_sample.specific_force_B;
      s.gyro_B = last_.imu_sample.gyro_B;
    }
  }
  last_.imu_sample = s;
  frame.imu = !lost;
  frame.imu_sample = s;
}

void SensorSuite::mocap(const MujocoPlant& plant, SensorFrame& frame) {
  const RigidState& b = plant.body();
  if (due(config_.mocap_rate)) {
    const Quat turn = exp_rotation(change_.mocap_rotation_W);
    Delayed d;
    const double latency = config_.mocap_latency + change_.mocap_extra_latency;
    d.arrival = count_ + static_cast<std::uint64_t>(std::llround(latency / step_));
    d.sample.t = plant.time() + change_.mocap_extra_latency;
    d.sample.p_WB = turn * (b.p_WB + b.q_WB * change_.mocap_offset_B) +
                    draw3(position_, config_.mocap_position_noise, config_.mocap_rate);
    d.sample.q_WB = turn * b.q_WB * exp_rotation(change_.mocap_turn_B) *
                    exp_rotation(draw3(attitude_, config_.mocap_attitude_noise, config_.mocap_rate));
    if (config_.mocap_stamp_jitter > 0)
      d.sample.t = std::max(0.0, d.sample.t + config_.mocap_stamp_jitter * jitter_.normal());
    // gaps of a mean length, and between them as long as the share of missing frames asks
    const double chance = chance_mocap_.uniform(), length = config_.mocap_dropout_length,
                 lost = config_.mocap_dropout;
    in_gap_ = in_gap_ ? chance >= 1 / length : chance < lost / ((1 - lost) * length);
    bool sent = !in_gap_;
    if (const SensorFault* bad = fault(SensorFault::Sensor::mocap, plant.time())) {
      sent = sent && !bad->silent;
      if (bad->frozen) {
        d.sample.p_WB = last_.mocap_sample.p_WB;
        d.sample.q_WB = last_.mocap_sample.q_WB;
      }
    }
    if (change_.pose_repeat > 0 && had_pose_ && chance_repeat_.uniform() < change_.pose_repeat) {
      d.sample.p_WB = last_.mocap_sample.p_WB;
      d.sample.q_WB = last_.mocap_sample.q_WB;
    }
    had_pose_ = true;
    last_.mocap_sample = d.sample;
    if (sent) in_flight_[head_++ % in_flight_.size()] = d;
  }
  if (tail_ < head_ && in_flight_[tail_ % in_flight_.size()].arrival <= count_) {
    frame.mocap = true;
    frame.mocap_sample = in_flight_[tail_++ % in_flight_.size()].sample;
  }
}

void SensorSuite::rotor(const MujocoPlant& plant, SensorFrame& frame) {
  if (!due(config_.rotor_rate)) return;
  const bool lost = chance_rotor_.uniform() < change_.rotor_dropout;
  RotorSample s;
  s.t = board_time(plant.time());
  s.alpha = plant.alpha();
  bool silent = false;
  for (std::size_t i = 0; i < plant.rotor_speed().size(); ++i) {
    double speed = plant.rotor_speed()[i] + draw(speed_, i, config_.rotor_noise, config_.rotor_rate);
    if (const SensorFault* bad =
            fault(SensorFault::Sensor::rotor_speed, plant.time(), static_cast<int>(i) + 1)) {
      speed *= bad->scale;
      if (bad->frozen) speed = last_.rotor_sample.speed[i];
      silent = silent || (bad->silent && bad->rotor == 0);
    }
    if (config_.half_period_quantisation) speed = speed_from_half_period(half_period_from_speed(speed));
    s.speed[i] = speed;
  }
  last_.rotor_sample = s;
  frame.rotor = !lost && !silent;
  frame.rotor_sample = s;
}

void SensorSuite::battery(const MujocoPlant& plant, SensorFrame& frame) {
  const double power = plant.mechanical_power() / config_.drive_efficiency;
  if (count_ > 0) energy_ += power * step_;
  if (!due(config_.battery_rate)) return;
  BatterySample s;
  s.t = board_time(plant.time());
  if (plant.world().battery) {
    std::tie(s.voltage, s.current) = plant.battery();
  } else {
    const double open = config_.battery_voltage - config_.battery_sag * energy_;
    s.current = power / std::max(1.0, open);
    s.voltage = open - config_.battery_resistance * s.current;
  }
  if (config_.battery_noise > 0) s.voltage += config_.battery_noise * voltage_.normal();
  if (const SensorFault* bad = fault(SensorFault::Sensor::battery, plant.time())) {
    if (bad->silent) return;
    s.voltage *= bad->scale;
    if (bad->frozen) {
      s.voltage = last_.battery_sample.voltage;
      s.current = last_.battery_sample.current;
    }
  }
  last_.battery_sample = s;
  frame.battery = true;
  frame.battery_sample = s;
}

void SensorSuite::sample(const MujocoPlant& plant, SensorFrame& frame) {
  frame.imu = frame.mocap = frame.rotor = frame.battery = false;
  imu(plant, frame);
  mocap(plant, frame);
  rotor(plant, frame);
  battery(plant, frame);
  ++count_;
}

}  // namespace omniflight::proof
