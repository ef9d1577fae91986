// The inertial sensor: where it sits, what shakes it, and what it makes of what it feels.
#pragma once

#include "low_pass.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::simulation {

class Imu {
 public:
  Imu(const SensorConfig& config, const physics::Sensing& sensing, double step, std::uint64_t seed);
  /// Every step: mode, vibration and filters go on between the samples.
  void follow(const Plant& plant);
  /// A sample is due.
  void sample(ImuSample& out);

 private:
  Vec3 normal3(double scale) { return scale * Vec3(random_.normal(), random_.normal(), random_.normal()); }
  Vec3 vibration(const Plant& plant);

  SensorConfig config_;
  physics::Sensing sensing_;
  double step_;
  Random random_, walk_random_, stale_random_;
  double acc_rms_, gyro_rms_;
  LowPass acc_mode_, gyro_mode_, acc_filter_, gyro_filter_;
  std::array<double, vehicle::kMaxRotors> phase_{};  ///< rad, of each rotor
  Vec3 acc_walk_ = Vec3::Zero(), gyro_walk_ = Vec3::Zero();
  Vec3 acc_ = Vec3::Zero(), gyro_ = Vec3::Zero();
  ImuSample last_;
  bool sampled_ = false;
};

}  // namespace omniflight::simulation
