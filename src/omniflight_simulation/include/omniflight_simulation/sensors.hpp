// Sensors with their own rates, latency, noise and bias, fed by a Plant.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "omniflight_core/random.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_physics/sensing.hpp"
#include "omniflight_simulation/plant.hpp"

namespace omniflight::simulation {

/// The sensors as they are installed. Noise densities are those of data sheets, one-sided: white noise of a
/// sampled sensor has the rms density * sqrt(rate / 2), and adds to the rms given for a sample.
struct SensorConfig {
  double imu_rate = 1000;                          ///< Hz
  Vec3 imu_position = Vec3::Zero();                ///< m, body frame: f + dw x r + w x (w x r)
  double accelerometer_noise = 0;                  ///< m/s^2, rms a sample and axis
  double accelerometer_noise_density = 0;          ///< m/s^2/sqrt(Hz)
  Vec3 accelerometer_bias = Vec3::Zero();          ///< m/s^2
  double accelerometer_bias_walk = 0;              ///< m/s^2/sqrt(s), random walk of the bias
  Vec3 accelerometer_scale = Vec3::Zero();         ///< 1, relative error
  Vec3 accelerometer_misalignment = Vec3::Zero();  ///< rad, f + d x f
  double accelerometer_filter = 0;                 ///< Hz, cut-off of a second-order low-pass; 0 = none
  double gyro_noise = 0;                           ///< rad/s, rms a sample and axis
  double gyro_noise_density = 0;                   ///< rad/s/sqrt(Hz)
  Vec3 gyro_bias = Vec3::Zero();                   ///< rad/s
  double gyro_bias_walk = 0;                       ///< rad/s/sqrt(s)
  Vec3 gyro_scale = Vec3::Zero();                  ///< 1, relative error
  double gyro_filter = 0;                          ///< Hz, cut-off of a second-order low-pass; 0 = none
  double mocap_rate = 250;                         ///< Hz
  double mocap_position_noise = 0;                 ///< m, rms an axis
  double mocap_attitude_noise = 0;                 ///< rad, rms an axis
  double mocap_latency = 0;                        ///< s, from exposure to arrival
  double mocap_dropout = 0;                        ///< share of the frames that is missing
  double mocap_dropout_length = 1;                 ///< frames, mean length of a gap
  double mocap_stamp_jitter = 0;                   ///< s, rms error of a stamp
  double rotor_rate = 250;                         ///< Hz
  double rotor_noise = 0;                          ///< rad/s, rms
  bool half_period_quantisation =
      false;                         ///< speeds in whole microseconds of half a period, as the boards report
  double battery_rate = 1;           ///< Hz
  double battery_voltage = 16.8;     ///< V, full and open circuit
  double battery_resistance = 0.03;  ///< ohm
  double battery_sag = 2.0e-5;       ///< V/J drawn
  double battery_noise = 0;          ///< V, rms
  double drive_efficiency = 0.7;     ///< mechanical power per electrical power
  /// Clock of the boards: what they send (IMU, rotors, battery) is stamped (1 + skew) t + offset.
  double board_clock_offset = 0;  ///< s
  double board_clock_skew = 0;    ///< 1
};

/// Reads the fields of SensorConfig (with units in the names: imu_rate_hz, mocap_latency_s, ...). Unknown
/// keys are refused by the caller's finish().
SensorConfig read_sensor_config(files::YamlReader yaml);

struct ImuSample {
  double t = 0;  ///< s, by the clock of the board
  Vec3 specific_force_B = Vec3::Zero(), gyro_B = Vec3::Zero();
};
struct MocapSample {
  double t = 0;  ///< s, when the pose was taken
  Vec3 p_WB = Vec3::Zero();
  Quat q_WB = Quat::Identity();
};
struct RotorSample {
  double t = 0;                                     ///< s, by the clock of the board
  std::array<double, vehicle::kMaxRotors> speed{};  ///< rad/s, signed
  double alpha = 0;                                 ///< rad
};
struct BatterySample {
  double t = 0;
  double voltage = 0, current = 0;  ///< V, A
};

/// What arrived at one instant.
struct SensorFrame {
  bool imu = false, mocap = false, rotor = false, battery = false;
  ImuSample imu_sample;
  MocapSample mocap_sample;
  RotorSample rotor_sample;
  BatterySample battery_sample;
};

/// Each sensor has its own random stream, so switching one off changes no other. The effects of the model
/// that alter sensing come on top of the configuration. Allocates nothing after construction.
class SensorSuite {
 public:
  SensorSuite(const SensorConfig& config, const physics::Model& model, double step, std::uint64_t seed);
  SensorSuite(SensorSuite&&) noexcept;
  SensorSuite& operator=(SensorSuite&&) noexcept;
  ~SensorSuite();
  /// Call once a step (and once before the first). Fills frame with what is due.
  void sample(const Plant& plant, SensorFrame& frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace omniflight::simulation
