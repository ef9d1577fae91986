// Sensors keep their rates, statistics, latency and faults.
#include <cmath>

#include "fixture.hpp"
#include "omniflight_proof/sensors.hpp"

namespace omniflight::proof {
namespace {

TEST(Sensors, IdealOnesReadTheTruthAtTheirRates) {
  MujocoPlant plant = make({}, {.p_WB = Vec3(0, 0, 5), .w_WB_B = Vec3(0.1, 0.2, 0.3)});
  plant.set_command(hover_speeds(plant.vehicle()), 0);
  SensorSuite sensors({}, {}, 0.001, 1);
  SensorFrame frame;
  int imu = 0, mocap = 0, rotor = 0, battery = 0;
  for (int k = 0; k < 1000; ++k) {
    sensors.sample(plant, frame);
    imu += frame.imu;
    mocap += frame.mocap;
    rotor += frame.rotor;
    battery += frame.battery;
    expect_near(frame.imu_sample.specific_force_B, plant.specific_force(), 1e-12);
    expect_near(frame.imu_sample.gyro_B, plant.body().w_WB_B, 1e-12);
    if (frame.mocap) expect_near(frame.mocap_sample.p_WB, plant.body().p_WB, 1e-12);
    if (frame.rotor) {
      EXPECT_EQ(frame.rotor_sample.speed[4], plant.rotor_speed()[4]);
    }
    ASSERT_TRUE(plant.step());
  }
  EXPECT_EQ(imu, 1000);
  EXPECT_EQ(mocap, 250);
  EXPECT_EQ(rotor, 250);
  EXPECT_EQ(battery, 1);
}

TEST(Sensors, AHeldVehicleFeelsGravityAndALeverArmTheCentripetal) {
  MujocoPlant plant = make({}, {.p_WB = Vec3(0, 0, 900), .w_WB_B = Vec3(0, 0, 4)});
  SensorChange change;
  change.imu_p_B = Vec3(0.05, 0, 0);
  SensorSuite sensors({}, change, 0.001, 1);
  SensorFrame frame;
  sensors.sample(plant, frame);
  expect_near(frame.imu_sample.specific_force_B, Vec3(-16 * 0.05, 0, kGravity), 1e-9, "still held");
}

TEST(Sensors, NoiseHasItsRmsAndLatencyItsTime) {
  SensorConfig config;
  config.accelerometer_noise = 0.1;
  config.mocap_latency = 0.02;
  config.mocap_dropout = 0.1;
  for (const double correlation : {0.0, 0.01}) {
    MujocoPlant plant = make({});
    SensorChange change;
    change.noise_correlation_time = correlation;
    SensorSuite sensors(config, change, 0.001, 3);
    SensorFrame frame;
    double sum = 0, product = 0, before = 0;
    int frames = 0;
    for (int k = 0; k < 4000; ++k) {
      sensors.sample(plant, frame);
      const double e = frame.imu_sample.specific_force_B.x();
      sum += e * e / 4000;
      product += e * before / 4000;
      before = e;
      if (frame.mocap) {
        ++frames;
        EXPECT_NEAR(plant.time() - frame.mocap_sample.t, 0.02, 1e-9);
      }
      ASSERT_TRUE(plant.step(true));
    }
    EXPECT_NEAR(std::sqrt(sum), 0.1, correlation > 0 ? 0.02 : 0.005);
    EXPECT_NEAR(product / sum, correlation > 0 ? std::exp(-0.1) : 0.0, 0.06);
    EXPECT_NEAR(frames, 900, 40);
  }
}

TEST(Sensors, FaultsFreezeScaleAndSilence) {
  using Sensor = SensorFault::Sensor;
  SensorChange change;
  change.faults = {{.sensor = Sensor::rotor_speed, .rotor = 2, .scale = 0.5},
                   {.sensor = Sensor::mocap, .from = 0.1, .until = 0.2, .silent = true},
                   {.sensor = Sensor::battery, .frozen = true}};
  change.board_clock_skew = 1e-3;
  change.board_clock_offset = 2.0;
  SensorConfig config;
  config.battery_rate = 100;
  MujocoPlant plant = make({});
  plant.set_command(std::vector<double>(8, 600.0), 0);
  SensorSuite sensors(config, change, 0.001, 1);
  SensorFrame frame;
  int while_silent = 0;
  for (int k = 0; k < 500; ++k) {
    sensors.sample(plant, frame);
    if (frame.mocap && plant.time() > 0.1 && plant.time() < 0.2) ++while_silent;
    if (frame.rotor) {
      EXPECT_EQ(frame.rotor_sample.speed[1], 0.5 * plant.rotor_speed()[1]);
    }
    EXPECT_NEAR(frame.imu_sample.t, 1.001 * plant.time() + 2, 1e-9);
    if (frame.battery) {
      EXPECT_EQ(frame.battery_sample.voltage, 0.0) << "it never had another value";
    }
    ASSERT_TRUE(plant.step(true));
  }
  EXPECT_EQ(while_silent, 0);
}

}  // namespace
}  // namespace omniflight::proof
