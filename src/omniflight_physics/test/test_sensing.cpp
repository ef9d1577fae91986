// Effects on the sensors say with numbers what the sensors then do.
#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

Sensing sensed(const char* id, const std::vector<double>& theta) {
  EXPECT_EQ(static_cast<int>(theta.size()), find_effect(id)->parameter_count()) << id;
  Sensing s;
  find_effect(id)->alter_sensing(theta.data(), s);
  return s;
}

TEST(Sensing, TakesTheParametersOver) {
  EXPECT_EQ(sensed("imu_lever_arm", {0.01, 0.02, 0.03}).imu_lever_arm, Vec3(0.01, 0.02, 0.03));
  const Sensing body = sensed("mocap_offset", {1e-2, 2e-2, 3e-2, 0.1, 0.2, 0.3});
  EXPECT_EQ(body.mocap_offset, Vec3(1e-2, 2e-2, 3e-2));
  EXPECT_EQ(body.mocap_misalignment, Vec3(0.1, 0.2, 0.3));
  const Sensing clock = sensed("clock_offset", {0.02, 5e-5});
  EXPECT_EQ(clock.mocap_clock_offset, 0.02);
  EXPECT_EQ(clock.mocap_clock_skew, 5e-5);
  const Sensing filter = sensed("sensor_filter", {0.005, 0.003, 1.0});
  EXPECT_EQ(filter.gyro_filter_time, 0.005);
  EXPECT_EQ(filter.accelerometer_filter_time, 0.003);
  EXPECT_EQ(filter.filter_damping, 1.0);
  const Sensing shaken = sensed("vibration", {2e-6, 0.01});
  EXPECT_EQ(shaken.imbalance, 2e-6);
  EXPECT_EQ(shaken.rectification, 0.01);
  const Sensing mode = sensed("structural_mode", {0.5, 14, 0.03});
  EXPECT_EQ(mode.mode_participation, 0.5);
  EXPECT_EQ(mode.mode_frequency, 14);
  EXPECT_EQ(mode.mode_damping, 0.03);
  const Sensing cell = sensed("battery_sensor_fault", {0.3, 0.01, 0.1});
  EXPECT_EQ(cell.voltage_bias, 0.3);
  EXPECT_EQ(cell.voltage_scale, 0.01);
  EXPECT_EQ(cell.current_scale, 0.1);
  const Sensing battery = sensed("battery_sag", {0.05, 1e-4, 15, 1});
  EXPECT_EQ(battery.battery_resistance, 0.05);
  EXPECT_EQ(battery.battery_drop, 1e-4);
}

TEST(RotorSpeedSensorFault, NamesOneRotorAndFreezesInTime) {
  const Sensing s = sensed("rotor_speed_sensor_fault", {3, 0.05, 10, 2.5});
  EXPECT_EQ(s.rotor_fault, 2);
  EXPECT_EQ(s.rotor_fault_scale, 0.05);
  EXPECT_EQ(s.rotor_fault_bias, 10);
  EXPECT_EQ(s.rotor_fault_freeze, 2.5);
  EXPECT_EQ(sensed("rotor_speed_sensor_fault", {3, 0.05, 10, 1e6}).rotor_fault_freeze,
            std::numeric_limits<double>::infinity());
}

TEST(StaleSamples, OfTwoCausesAreIndependent) {
  Sensing s = sensed("stale_samples", {0.2, 0.1});
  EXPECT_NEAR(s.stale_mocap, 0.2, 1e-15);
  const double more[] = {0.5, 0.0};
  find_effect("stale_samples")->alter_sensing(more, s);
  EXPECT_NEAR(s.stale_mocap, 1 - 0.8 * 0.5, 1e-15);
  EXPECT_NEAR(s.stale_imu, 0.1, 1e-15);
}

}  // namespace
}  // namespace omniflight::physics::testing
