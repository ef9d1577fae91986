// Sensors of the proof's plant: own rates, noise, latency and faults, fed by a MujocoPlant.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "omniflight_core/random.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_proof/world.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

class MujocoPlant;

/// What is known about the sensors: the fields of a sensor file (omniflight.sensors/1).
struct SensorConfig {
  double imu_rate = 1000;                  ///< Hz
  Vec3 imu_position = Vec3::Zero();        ///< m, body
  double accelerometer_noise = 0;          ///< m/s^2 rms an axis and sample
  double accelerometer_noise_density = 0;  ///< m/s^2/sqrt(Hz), one-sided: rms density * sqrt(rate / 2) on top
  Vec3 accelerometer_bias = Vec3::Zero();  ///< m/s^2
  double accelerometer_bias_walk = 0;      ///< m/s^2/sqrt(s)
  Vec3 accelerometer_scale = Vec3::Zero();         ///< relative error
  Vec3 accelerometer_misalignment = Vec3::Zero();  ///< rad, reads f + d x f
  double accelerometer_filter = 0;                 ///< Hz, two equal poles, -3 dB; 0: none
  double gyro_noise = 0;                           ///< rad/s rms an axis and sample
  double gyro_noise_density = 0;                   ///< rad/s/sqrt(Hz)
  Vec3 gyro_bias = Vec3::Zero();                   ///< rad/s
  double gyro_bias_walk = 0;                       ///< rad/s/sqrt(s)
  Vec3 gyro_scale = Vec3::Zero();                  ///< relative error
  double gyro_filter = 0;                          ///< Hz, two equal poles, -3 dB; 0: none
  double mocap_rate = 250;                         ///< Hz
  double mocap_position_noise = 0;                 ///< m rms an axis
  double mocap_attitude_noise = 0;                 ///< rad rms an axis
  double mocap_latency = 0;               ///< s from exposure to arrival; the stamp is of the exposure
  double mocap_dropout = 0;               ///< share of missing frames
  double mocap_dropout_length = 1;        ///< frames, mean length of a gap
  double mocap_stamp_jitter = 0;          ///< s rms
  double rotor_rate = 250;                ///< Hz
  double rotor_noise = 0;                 ///< rad/s rms
  bool half_period_quantisation = false;  ///< speeds in whole microseconds of half a period
  double battery_rate = 1;                ///< Hz
  double battery_voltage = 16.8;          ///< V, full, without load
  double battery_resistance = 0.03;       ///< ohm
  double battery_sag = 2e-5;              ///< V per J drawn
  double battery_noise = 0;               ///< V rms
  double drive_efficiency = 0.7;          ///< mechanical per electrical power
  double board_clock_offset = 0;          ///< s, stamps of IMU, rotors and battery are (1 + skew) t + offset
  double board_clock_skew = 0;
};
/// Reads a sensor file; an unknown key or a number out of range is refused with file, line, field and unit.
Result<SensorConfig> load_sensors(const std::filesystem::path& path);

struct ImuSample {
  double t = 0;  ///< s, on the board's clock
  Vec3 specific_force_B = Vec3::Zero(), gyro_B = Vec3::Zero();
};
struct MocapSample {
  double t = 0;  ///< s, of the exposure
  Vec3 p_WB = Vec3::Zero();
  Quat q_WB = Quat::Identity();
};
struct RotorSample {
  double t = 0;                                     ///< s, on the board's clock
  std::array<double, vehicle::kMaxRotors> speed{};  ///< rad/s, signed
  double alpha = 0;                                 ///< rad, as the servo reports it
};
struct BatterySample {
  double t = 0;                     ///< s, on the board's clock
  double voltage = 0, current = 0;  ///< V, A drawn
};
/// What arrived at one instant.
struct SensorFrame {
  bool imu = false, mocap = false, rotor = false, battery = false;
  ImuSample imu_sample;
  MocapSample mocap_sample;
  RotorSample rotor_sample;
  BatterySample battery_sample;
};

/// Every sensor has its own random stream. Allocates nothing after construction.
class SensorSuite {
 public:
  /// step [s] is the time between two calls of sample().
  SensorSuite(const SensorConfig& config, const SensorChange& change, double step, std::uint64_t seed);
  /// Once before the first step and once after each; fills frame with what arrives now.
  void sample(const MujocoPlant& plant, SensorFrame& frame);

 private:
  struct Noise {  ///< white, or first-order coloured with the same rms
    Random rng;
    std::array<double, vehicle::kMaxRotors> state{};
  };
  struct LowPass {  ///< two equal poles
    Vec3 first = Vec3::Zero(), second = Vec3::Zero();
    bool begun = false;
    Vec3 operator()(const Vec3& input, double pass);
  };
  struct Delayed {
    std::uint64_t arrival = 0;
    MocapSample sample;
  };
  bool due(double rate) const;
  double draw(Noise& noise, std::size_t channel, double rms, double rate);
  Vec3 draw3(Noise& noise, double rms, double rate);
  const SensorFault* fault(SensorFault::Sensor sensor, double t, int rotor = 0) const;
  double board_time(double t) const;
  void imu(const MujocoPlant& plant, SensorFrame& frame);
  void mocap(const MujocoPlant& plant, SensorFrame& frame);
  void rotor(const MujocoPlant& plant, SensorFrame& frame);
  void battery(const MujocoPlant& plant, SensorFrame& frame);

  SensorConfig config_;
  SensorChange change_;
  double step_;
  std::uint64_t count_ = 0;
  Noise accelerometer_, gyro_, position_, attitude_, speed_;
  Random chance_imu_, chance_mocap_, chance_rotor_, chance_repeat_, walk_, jitter_, voltage_;
  bool had_pose_ = false;
  Vec3 accelerometer_walk_ = Vec3::Zero(), gyro_walk_ = Vec3::Zero();
  LowPass filters_[4];  ///< accelerometer and gyro of the file, then both of the change
  bool in_gap_ = false;
  std::array<double, vehicle::kMaxRotors> phase_{};
  double energy_ = 0;
  SensorFrame last_;  ///< what a frozen sensor repeats
  std::vector<Delayed> in_flight_;
  std::size_t head_ = 0, tail_ = 0;
};

}  // namespace omniflight::proof
