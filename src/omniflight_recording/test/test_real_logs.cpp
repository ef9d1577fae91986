#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "omniflight_recording/alignment.hpp"
#include "omniflight_recording/formats.hpp"
#include "real_data.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

Recording read(const std::string& relative, const std::string& map = {}) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  LoadOptions options;
  options.map = map;
  auto r = load(real_data(relative), options);
  EXPECT_TRUE(r) << (r ? "" : r.error().text());
  return r ? *r : Recording{};
}
double mean_norm(const Signal& s) { return s.values.rowwise().norm().mean(); }

TEST(RealLogs, BrushlessFlightIsInSiUnits) {
  NEEDS_REAL_DATA("flights/crazyflie_brushless/eckart30");
  const auto r = read("flights/crazyflie_brushless/eckart30");
  EXPECT_EQ(r.format, "crazyflie_microsd");
  EXPECT_FALSE(r.lost_anything());
  EXPECT_NEAR(r.duration_s, 24.109966 - 18.537391, 1e-6);
  EXPECT_EQ(r.find("gyro")->size(), 2789);
  EXPECT_EQ(r.find("position")->size(), 490);
  EXPECT_EQ(r.find("position")->source, "estPose locSrv.x");
  EXPECT_NEAR(r.find("acc")->values.col(2).mean(), 10.3, 1.0);  // flown with up to 25 degrees of bank
  const auto& speed = r.find("rotor_speed")->values;            // 15000 rev/min is 1571 rad/s
  EXPECT_EQ(speed.cols(), 4);
  EXPECT_NEAR(speed.mean(), 1600, 150);
  EXPECT_NEAR(r.find("vbat")->values.mean(), 3.8, 0.3);
  EXPECT_GT(r.find("pwm")->values.minCoeff(), 0.0);
  EXPECT_LT(r.find("pwm")->values.maxCoeff(), 1.0);
  EXPECT_NEAR((r.find("est_position")->values.row(1000) -
               resample(*r.find("position"), {r.find("est_position")->t_s[1000]}))
                  .norm(),
              0, 0.1);
}

TEST(RealLogs, TheGyroFollowsTheAttitudeRate) {
  NEEDS_REAL_DATA("flights/crazyflie_brushless/eckart30");
  const auto r = read("flights/crazyflie_brushless/eckart30");
  const auto lag = estimate_lag(*r.find("gyro"), rate_of_attitude(*r.find("est_attitude")));
  ASSERT_TRUE(lag) << lag.error().text();
  EXPECT_GT(lag->correlation, 0.5);  // raw gyro with vibration against a differentiated estimate
  EXPECT_NEAR(lag->gain, 1.0, 0.15);
  EXPECT_LT(std::abs(lag->lag_s), 0.01);
  EXPECT_LT(lag->standard_error_s, 0.005);
}

TEST(RealLogs, BrushedFlightHasAnotherLayout) {
  NEEDS_REAL_DATA("flights/crazyflie_brushed/jana04");
  const auto r = read("flights/crazyflie_brushed/jana04");
  EXPECT_FALSE(r.lost_anything());
  EXPECT_NEAR(mean_norm(*r.find("acc")), 9.81, 0.5);
  EXPECT_NEAR(r.find("rotor_speed")->values.mean(), 2070, 200);  // about 19800 rev/min
  EXPECT_LT(r.find("pwm")->values.maxCoeff(), 1.01);
}

TEST(RealLogs, DamagedPropellerFlightHasNoRotorSpeed) {
  NEEDS_REAL_DATA("flights/crazyflie_damaged_propeller/add_weight_W1_near_M4/E8_log02");
  const auto r = read("flights/crazyflie_damaged_propeller/add_weight_W1_near_M4/E8_log02");
  EXPECT_FALSE(r.lost_anything());
  EXPECT_EQ(r.find("rotor_speed"), nullptr);
  EXPECT_FALSE(r.require("rotor_speed"));
  EXPECT_EQ(r.find("position")->source, "fixedFrequency stateEstimate.x");
  EXPECT_NEAR(r.find("position")->median_period_s(), 0.0099, 2e-4);
  EXPECT_GT(r.find("motor_power")->values.maxCoeff(), 0.3);
  EXPECT_LE(r.find("motor_power")->values.maxCoeff(), 1.0);
}

TEST(RealLogs, EveryMicroSdLogOfTheFolderIsSound) {
  NEEDS_REAL_DATA("flights");
  int logs = 0;
  for (const char* folder : {"crazyflie_brushless", "crazyflie_brushed", "crazyflie_damaged_propeller"})
    for (const auto& entry : fs::recursive_directory_iterator(real_data("flights") / folder)) {
      if (!entry.is_regular_file() || entry.path().has_extension() || entry.path().filename() == "LICENSE")
        continue;
      const auto r = load(entry.path());
      ASSERT_TRUE(r) << r.error().text();
      EXPECT_FALSE(r->lost_anything()) << entry.path();
      ++logs;
    }
  EXPECT_GT(logs, 50);
}

TEST(RealLogs, CutAndDamagedMicroSdLogsAreReadAsFarAsTheyAreSound) {
  NEEDS_REAL_DATA("flights/crazyflie_brushless/eckart30");
  const auto whole = read("flights/crazyflie_brushless/eckart30");
  std::ifstream in(real_data("flights/crazyflie_brushless/eckart30"), std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const fs::path cut = fs::temp_directory_path() / ("omniflight_cut_" + std::to_string(::getpid()));
  const auto write = [&](std::string_view content) {
    std::ofstream out(cut, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
  };
  for (std::size_t size : {bytes.size() - 1, bytes.size() - 5, bytes.size() / 2, std::size_t{2000}}) {
    write(std::string_view(bytes).substr(0, size));
    const auto r = load(cut);
    ASSERT_TRUE(r) << r.error().text();
    EXPECT_TRUE(r->lost_anything()) << size;
    const Signal* gyro = r->find("gyro");
    ASSERT_NE(gyro, nullptr);
    EXPECT_LE(gyro->size(), whole.find("gyro")->size());
    EXPECT_EQ(gyro->values, whole.find("gyro")->values.topRows(gyro->size())) << size;
  }
  for (std::size_t size = 0; size < 1000; size += 3) {  // inside the header: refused, never a crash
    write(std::string_view(bytes).substr(0, size));
    const auto r = load(cut);
    EXPECT_TRUE(!r || r->lost_anything()) << size;
  }
  std::string damaged = bytes;
  for (std::size_t i = 0; i < 900; i += 3) {
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    write(std::string_view(damaged).substr(0, 4000));
    const auto r = load(cut);
    EXPECT_TRUE(!r || r->lost_anything()) << i;
    damaged[i] = bytes[i];
  }
  fs::remove(cut);
}

TEST(RealLogs, NanobenchThroughItsMap) {
  NEEDS_REAL_DATA("flights/nanobench/B2_circle_fast_rep2.csv.gz");
  const auto r = read("flights/nanobench/B2_circle_fast_rep2.csv.gz", "nanobench");
  EXPECT_EQ(r.format, "csv");
  EXPECT_GT(r.start_s, 1.7e9);
  EXPECT_NEAR(r.find("position")->median_period_s(), 0.01, 0.001);
  EXPECT_NEAR(mean_norm(*r.find("acc")), 9.81, 0.5);
  EXPECT_NEAR(r.find("vbat")->values.mean(), 3.5, 0.6);
  const auto lag = estimate_lag(*r.find("est_position"), *r.find("position"));
  ASSERT_TRUE(lag) << lag.error().text();
  EXPECT_NEAR(lag->gain, 1.0, 0.05);
}

TEST(RealLogs, CrazyfliePairsThroughTheirMapInMicroseconds) {
  NEEDS_REAL_DATA("flights/crazyflie_pairs/swapLL_cf101_00.csv.gz");
  const auto r = read("flights/crazyflie_pairs/swapLL_cf101_00.csv.gz");  // found by its columns
  EXPECT_EQ(r.notes.front().text, "its columns were read as the map crazyflie_pairs says");
  EXPECT_NEAR(r.find("acc")->median_period_s(), 0.01, 0.002);
  EXPECT_NEAR(r.find("acc")->values.col(2).mean(), 9.81, 0.4);
  EXPECT_NEAR(r.find("thrust_model")->values.rowwise().sum().mean(), 0.065 * 9.81, 0.1);  // about 65 g
}

}  // namespace
