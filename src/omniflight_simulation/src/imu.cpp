#include "imu.hpp"

#include <cmath>

namespace omniflight::simulation {
namespace {

double filter_time(double hz, double otherwise) { return hz > 0 ? 1 / (2 * kPi * hz) : otherwise; }

double rms(double a_sample, double density, double rate) {
  return std::sqrt(a_sample * a_sample + density * density * rate / 2);
}

}  // namespace

Imu::Imu(const SensorConfig& config, const physics::Sensing& sensing, double step, std::uint64_t seed)
    : config_(config),
      sensing_(sensing),
      step_(step),
      random_(seed, "imu"),
      walk_random_(seed, "imu bias"),
      stale_random_(seed, "imu stale"),
      acc_rms_(rms(config.accelerometer_noise, config.accelerometer_noise_density, config.imu_rate)),
      gyro_rms_(rms(config.gyro_noise, config.gyro_noise_density, config.imu_rate)) {
  sensing_.imu_lever_arm += config.imu_position;
  sensing_.accelerometer_bias += config.accelerometer_bias;
  sensing_.accelerometer_scale += config.accelerometer_scale;
  sensing_.accelerometer_misalignment += config.accelerometer_misalignment;
  sensing_.gyro_bias += config.gyro_bias;
  sensing_.gyro_scale += config.gyro_scale;
  if (sensing_.mode_participation != 0) {
    const double time = 1 / (2 * kPi * sensing_.mode_frequency);
    acc_mode_ = gyro_mode_ = LowPass(time, sensing_.mode_damping, step);
  }
  const auto filter = [&](double hz, double time) {
    return LowPass(filter_time(hz, time), sensing_.filter_damping, step);
  };
  acc_filter_ = filter(config.accelerometer_filter, sensing_.accelerometer_filter_time);
  gyro_filter_ = filter(config.gyro_filter, sensing_.gyro_filter_time);
}

Vec3 Imu::vibration(const Plant& plant) {
  Vec3 sum = Vec3::Zero();
  const auto speeds = plant.rotor_speed();
  const auto rotors = plant.situation().all_rotors();
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    phase_[i] = std::remainder(phase_[i] + speeds[i] * step_, 2 * kPi);
    const Vec3& n = rotors[i].n_B;
    const Vec3 x = n.cross(std::abs(n.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY()).normalized();
    // rotors are not in step: their first angles are spread by the golden ratio
    const double angle = phase_[i] + 2 * kPi * 0.618033988749895 * static_cast<double>(i);
    sum += sensing_.imbalance * speeds[i] * speeds[i] * (std::cos(angle) * x + std::sin(angle) * n.cross(x));
  }
  return sum;
}

void Imu::follow(const Plant& plant) {
  const Vec3& w = plant.body().w_WB_B;
  const Vec3& r = sensing_.imu_lever_arm;
  Vec3 f = plant.specific_force() + plant.angular_acceleration().cross(r) + w.cross(w.cross(r));
  Vec3 g = w;
  if (const double share = sensing_.mode_participation; share != 0) {
    f += share * (acc_mode_(f) - f);
    g += share * (gyro_mode_(g) - g);
  }
  if (sensing_.imbalance != 0) {
    const Vec3 shaken = vibration(plant);
    f += shaken;
    f.z() += sensing_.rectification * shaken.squaredNorm();
  }
  f += sensing_.accelerometer_misalignment.cross(f);
  f += sensing_.accelerometer_scale.cwiseProduct(f) + sensing_.accelerometer_bias;
  g += sensing_.gyro_scale.cwiseProduct(g) + sensing_.gyro_bias;
  acc_ = acc_filter_(f);
  gyro_ = gyro_filter_(g);
}

void Imu::sample(ImuSample& out) {
  if (config_.accelerometer_bias_walk > 0 || config_.gyro_bias_walk > 0) {
    const double root = sampled_ ? std::sqrt(1 / config_.imu_rate) : 0.0;
    const auto stride = [&] {
      return Vec3(root * Vec3(walk_random_.normal(), walk_random_.normal(), walk_random_.normal()));
    };
    acc_walk_ += config_.accelerometer_bias_walk * stride();
    gyro_walk_ += config_.gyro_bias_walk * stride();
  }
  out.specific_force_B = acc_ + acc_walk_ + normal3(acc_rms_);
  out.gyro_B = gyro_ + gyro_walk_ + normal3(gyro_rms_);
  if (sensing_.stale_imu > 0 && stale_random_.uniform() < sensing_.stale_imu && sampled_) {
    out.specific_force_B = last_.specific_force_B;
    out.gyro_B = last_.gyro_B;
  }
  last_ = out;
  sampled_ = true;
}

}  // namespace omniflight::simulation
