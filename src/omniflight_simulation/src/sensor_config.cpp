#include "omniflight_simulation/sensors.hpp"

namespace omniflight::simulation {

SensorConfig read_sensor_config(files::YamlReader yaml) {
  using files::between, files::non_negative;
  SensorConfig c;
  const auto number = [&yaml](const char* key, double& value, files::Bounds bounds) {
    value = yaml.number(key, bounds, value);
  };
  const auto vec3 = [&yaml](const char* key, Vec3& value, files::Bounds bounds) {
    value = yaml.vec3(key, bounds, value);
  };
  number("imu_rate_hz", c.imu_rate, between(1, 8000, "Hz"));
  vec3("imu_position_m", c.imu_position, between(-1, 1, "m"));
  number("accelerometer_noise_mps2", c.accelerometer_noise, between(0, 10, "m/s2"));
  number("accelerometer_noise_density_mps2_per_sqrt_hz", c.accelerometer_noise_density,
         between(0, 1, "m/s2/sqrt(Hz)"));
  vec3("accelerometer_bias_mps2", c.accelerometer_bias, between(-5, 5, "m/s2"));
  number("accelerometer_bias_walk_mps2_per_sqrt_s", c.accelerometer_bias_walk, between(0, 1, "m/s2/sqrt(s)"));
  vec3("accelerometer_scale", c.accelerometer_scale, between(-0.5, 0.5, "1"));
  vec3("accelerometer_misalignment_rad", c.accelerometer_misalignment, between(-0.5, 0.5, "rad"));
  number("accelerometer_filter_hz", c.accelerometer_filter, between(0, 4000, "Hz"));
  number("gyro_noise_radps", c.gyro_noise, between(0, 5, "rad/s"));
  number("gyro_noise_density_radps_per_sqrt_hz", c.gyro_noise_density, between(0, 0.5, "rad/s/sqrt(Hz)"));
  vec3("gyro_bias_radps", c.gyro_bias, between(-1, 1, "rad/s"));
  number("gyro_bias_walk_radps_per_sqrt_s", c.gyro_bias_walk, between(0, 0.5, "rad/s/sqrt(s)"));
  vec3("gyro_scale", c.gyro_scale, between(-0.5, 0.5, "1"));
  number("gyro_filter_hz", c.gyro_filter, between(0, 4000, "Hz"));
  number("mocap_rate_hz", c.mocap_rate, between(1, 1000, "Hz"));
  number("mocap_position_noise_m", c.mocap_position_noise, between(0, 0.1, "m"));
  number("mocap_attitude_noise_rad", c.mocap_attitude_noise, between(0, 0.2, "rad"));
  number("mocap_latency_s", c.mocap_latency, between(0, 0.2, "s"));
  number("mocap_dropout", c.mocap_dropout, between(0, 0.9, "1"));
  number("mocap_dropout_length_frames", c.mocap_dropout_length, between(1, 1000, "frames"));
  number("mocap_stamp_jitter_s", c.mocap_stamp_jitter, between(0, 0.01, "s"));
  number("rotor_rate_hz", c.rotor_rate, between(1, 4000, "Hz"));
  number("rotor_noise_radps", c.rotor_noise, between(0, 50, "rad/s"));
  c.half_period_quantisation = yaml.boolean("half_period_quantisation", c.half_period_quantisation);
  number("battery_rate_hz", c.battery_rate, between(0.1, 100, "Hz"));
  number("battery_voltage_V", c.battery_voltage, between(1, 100, "V"));
  number("battery_resistance_ohm", c.battery_resistance, non_negative("ohm"));
  number("battery_sag_V_per_J", c.battery_sag, non_negative("V/J"));
  number("battery_noise_V", c.battery_noise, between(0, 1, "V"));
  number("drive_efficiency", c.drive_efficiency, between(0.05, 1, "1"));
  number("board_clock_offset_s", c.board_clock_offset, between(-1, 1, "s"));
  number("board_clock_skew", c.board_clock_skew, between(-0.01, 0.01, "1"));
  return c;
}

}  // namespace omniflight::simulation
