#include "omniflight_files/yaml.hpp"
#include "omniflight_proof/sensors.hpp"

namespace omniflight::proof {

Result<SensorConfig> load_sensors(const std::filesystem::path& path) {
  auto yaml = files::YamlReader::load(path);
  if (!yaml) return Failure(yaml.error());
  if (yaml->string("schema") != "omniflight.sensors/1")
    yaml->error_at("schema", "is not omniflight.sensors/1");
  SensorConfig c;
  const auto number = [&](const char* key, double& x, double low, double high, const char* unit) {
    x = yaml->number(key, files::between(low, high, unit), x);
  };
  const auto vec3 = [&](const char* key, Vec3& x, double most, const char* unit) {
    x = yaml->vec3(key, files::between(-most, most, unit), x);
  };
  number("imu_rate_hz", c.imu_rate, 1, 8000, "Hz");
  vec3("imu_position_m", c.imu_position, 1, "m");
  number("accelerometer_noise_mps2", c.accelerometer_noise, 0, 10, "m/s2");
  number("accelerometer_noise_density_mps2_per_sqrt_hz", c.accelerometer_noise_density, 0, 1,
         "m/s2/sqrt(Hz)");
  vec3("accelerometer_bias_mps2", c.accelerometer_bias, 5, "m/s2");
  number("accelerometer_bias_walk_mps2_per_sqrt_s", c.accelerometer_bias_walk, 0, 1, "m/s2/sqrt(s)");
  vec3("accelerometer_scale", c.accelerometer_scale, 0.5, "1");
  vec3("accelerometer_misalignment_rad", c.accelerometer_misalignment, 0.5, "rad");
  number("accelerometer_filter_hz", c.accelerometer_filter, 0, 4000, "Hz");
  number("gyro_noise_radps", c.gyro_noise, 0, 5, "rad/s");
  number("gyro_noise_density_radps_per_sqrt_hz", c.gyro_noise_density, 0, 0.5, "rad/s/sqrt(Hz)");
  vec3("gyro_bias_radps", c.gyro_bias, 1, "rad/s");
  number("gyro_bias_walk_radps_per_sqrt_s", c.gyro_bias_walk, 0, 0.5, "rad/s/sqrt(s)");
  vec3("gyro_scale", c.gyro_scale, 0.5, "1");
  number("gyro_filter_hz", c.gyro_filter, 0, 4000, "Hz");
  number("mocap_rate_hz", c.mocap_rate, 1, 1000, "Hz");
  number("mocap_position_noise_m", c.mocap_position_noise, 0, 0.1, "m");
  number("mocap_attitude_noise_rad", c.mocap_attitude_noise, 0, 0.2, "rad");
  number("mocap_latency_s", c.mocap_latency, 0, 0.2, "s");
  number("mocap_dropout", c.mocap_dropout, 0, 0.9, "1");
  number("mocap_dropout_length_frames", c.mocap_dropout_length, 1, 1000, "frames");
  number("mocap_stamp_jitter_s", c.mocap_stamp_jitter, 0, 0.01, "s");
  number("rotor_rate_hz", c.rotor_rate, 1, 4000, "Hz");
  number("rotor_noise_radps", c.rotor_noise, 0, 50, "rad/s");
  c.half_period_quantisation = yaml->boolean("half_period_quantisation", c.half_period_quantisation);
  number("battery_rate_hz", c.battery_rate, 0.1, 100, "Hz");
  number("battery_voltage_V", c.battery_voltage, 1, 100, "V");
  number("battery_resistance_ohm", c.battery_resistance, 0, 10, "ohm");
  number("battery_sag_V_per_J", c.battery_sag, 0, 1, "V/J");
  number("battery_noise_V", c.battery_noise, 0, 1, "V");
  number("drive_efficiency", c.drive_efficiency, 0.05, 1, "1");
  number("board_clock_offset_s", c.board_clock_offset, -1, 1, "s");
  number("board_clock_skew", c.board_clock_skew, -0.01, 0.01, "1");
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  return c;
}

}  // namespace omniflight::proof
