// Sensors with their own rates, latency, noise and bias, fed by a Plant.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "omniflight_core/random.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_simulation/plant.hpp"

namespace omniflight::simulation {

struct SensorConfig {
  double imu_rate = 1000;                  ///< Hz
  double accelerometer_noise = 0;          ///< m/s^2, rms a sample and axis
  Vec3 accelerometer_bias = Vec3::Zero();  ///< m/s^2
  double gyro_noise = 0;                   ///< rad/s, rms a sample and axis
  Vec3 gyro_bias = Vec3::Zero();           ///< rad/s
  double mocap_rate = 250;                 ///< Hz
  double mocap_position_noise = 0;         ///< m, rms an axis
  double mocap_attitude_noise = 0;         ///< rad, rms an axis
  double mocap_latency = 0;                ///< s, from exposure to arrival
  double mocap_dropout = 0;                ///< probability that a frame is missing
  double rotor_rate = 250;                 ///< Hz
  double rotor_noise = 0;                  ///< rad/s, rms
  bool half_period_quantisation =
      false;                         ///< speeds in whole microseconds of half a period, as the boards report
  double battery_rate = 1;           ///< Hz
  double battery_voltage = 16.8;     ///< V, full and open circuit
  double battery_resistance = 0.03;  ///< ohm
  double battery_sag = 2.0e-5;       ///< V/J drawn
  double drive_efficiency = 0.7;     ///< mechanical power per electrical power
};

/// Reads the fields of SensorConfig (with units in the names: imu_rate_hz, mocap_latency_s, ...). Unknown
/// keys are refused by the caller's finish().
SensorConfig read_sensor_config(files::YamlReader yaml);

struct ImuSample {
  double t = 0;  ///< s
  Vec3 specific_force_B = Vec3::Zero(), gyro_B = Vec3::Zero();
};
struct MocapSample {
  double t = 0;  ///< s, when the pose was taken
  Vec3 p_WB = Vec3::Zero();
  Quat q_WB = Quat::Identity();
};
struct RotorSample {
  double t = 0;                                     ///< s
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

/// Each sensor has its own random stream, so switching one off changes no other. Allocates nothing after
/// construction.
class SensorSuite {
 public:
  SensorSuite(const SensorConfig& config, const physics::Model& model, double step, std::uint64_t seed);
  /// Call once a step (and once before the first). Fills frame with what is due.
  void sample(const Plant& plant, SensorFrame& frame);

 private:
  bool due(double rate) const;
  Vec3 normal3(Random& rng, double scale) { return scale * Vec3(rng.normal(), rng.normal(), rng.normal()); }

  SensorConfig config_;
  physics::Sensing sensing_;
  double step_;
  std::uint64_t count_ = 0;
  Random imu_rng_, mocap_rng_, rotor_rng_;
  double energy_ = 0;  ///< J drawn so far
  struct Delayed {
    std::uint64_t arrival;
    MocapSample sample;
  };
  std::vector<Delayed> in_flight_;  ///< a ring of poses that have not arrived
  std::size_t head_ = 0, tail_ = 0;
};

}  // namespace omniflight::simulation
