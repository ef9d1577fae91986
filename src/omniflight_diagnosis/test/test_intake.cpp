// What is known before anything is fitted: clocks, excitation, what is told, and stopping early.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_diagnosis/told.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

vehicle::Vehicle omnimorph() {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle("omnimorph");
  EXPECT_TRUE(v) << v.error().text();
  return *v;
}

test::Flown swaying() {
  test::Flown flown;
  flown.duration_s = 30;
  flown.sway = 0.2;
  flown.torque_noise_Nm = 0.001;
  return flown;
}

const Alignment* pair(const std::vector<Alignment>& all, const std::string& early, const std::string& late) {
  for (const Alignment& a : all)
    if (a.early == early && a.late == late) return &a;
  return nullptr;
}

TEST(Intake, MeasuresLagAndSkewOfTheAttitude) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, swaying());
  for (double& t : r.signals["attitude"].t_s) t = 0.012 + (1 + 400e-6) * t;
  const std::vector<Alignment> all = align_signals(r);
  const Alignment* a = pair(all, "gyro", "attitude");
  ASSERT_TRUE(a);
  // at the middle of the recording the skew has added 6 ms
  EXPECT_NEAR(a->lag_s, 0.018, 4 * a->lag_se + 0.001);
  EXPECT_LT(a->lag_se, 0.002);
  EXPECT_NEAR(a->skew, 400e-6, 4 * a->skew_se + 20e-6);
  EXPECT_GT(a->skew, 3 * a->skew_se);
}

TEST(Intake, CheckTellsWhatAFlightCannotShowInSeconds) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown hover;
  hover.duration_s = 20;
  hover.climb_m = 0;
  hover.side_m = 0.15;
  const recording::Recording r = test::fly(v, {}, hover);
  const auto c = check(r, v);
  ASSERT_TRUE(c) << c.error().text();
  EXPECT_TRUE(c->findings.empty());
  EXPECT_FALSE(c->intake.signals.empty());
  EXPECT_FALSE(c->intake.excitation.empty());
  // in hover a mass and a thrust scale are one direction
  const auto& groups = c->intake.alias_groups;
  const bool together = std::any_of(groups.begin(), groups.end(), [](const auto& g) {
    const auto has = [&](const char* id) { return std::find(g.begin(), g.end(), id) != g.end(); };
    return has("payload_mass") && has("thrust_scale");
  });
  EXPECT_TRUE(together) << c->summary;
  EXPECT_NE(c->summary.find("Nothing was fitted"), std::string::npos);
}

TEST(Intake, StopsInTimeAndSaysWhatIsLeftOut) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown flown;
  flown.duration_s = 15;
  const recording::Recording r = test::fly(v, {{physics::find_effect("payload_mass"), {0.3}}}, flown);
  Options o;
  int asked = 0;
  o.stop = [&] { return ++asked > 5; };
  const auto d = diagnose(std::span(&r, 1), {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_FALSE(d->left_out.empty());
  EXPECT_NE(d->summary.find("Time was up; left out: further candidates"), std::string::npos) << d->summary;
  EXPECT_FALSE(d->fit.in_sample.empty());
}

TEST(Intake, TakesWhatIsToldAndRefusesWhatIsNoNumber) {
  const std::string path = testing::TempDir() + "flight.csv.told.yaml";
  std::ofstream(path) << "environment: {floor_z_m: 0.055, air_density_kgpm3: 1.18}\n"
                         "sensors: {accelerometer: {bias_mps2: 0.08}, camera: {shutter_ms: 3}}\n"
                         "controller: {kp: [10, 10, 12], kv: 6}\nneighbours: [other.csv]\n";
  EXPECT_EQ(told_beside(testing::TempDir() + "flight.csv"), path);
  const auto told = load_told(path);
  ASSERT_TRUE(told) << told.error().text();
  ASSERT_EQ(told->neighbours.size(), 1u);
  EXPECT_EQ(told->neighbours[0], testing::TempDir() + "other.csv");
  EXPECT_EQ(told->ignored, std::vector<std::string>{"sensors.camera.shutter_ms"});
  Options o;
  apply(*told, o);
  EXPECT_DOUBLE_EQ(o.environment.floor_z, 0.055);
  EXPECT_TRUE(o.floor_told);
  EXPECT_DOUBLE_EQ(o.environment.air_density, 1.18);
  EXPECT_DOUBLE_EQ(o.tolerance.accelerometer_lateral, 0.08);
  EXPECT_DOUBLE_EQ(o.controller.kp.z(), 12);
  EXPECT_DOUBLE_EQ(o.controller.kv.x(), 6);
  std::ofstream(path) << "environment: {floor_z_m: high}\n";
  const auto bad = load_told(path);
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().text().find("environment.floor_z_m"), std::string::npos) << bad.error().text();
}

}  // namespace
}  // namespace omniflight::diagnosis
