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

/// A body that turns briskly about all axes for a minute: gyro with noise, attitude from the same rates.
recording::Recording turning() {
  recording::Recording r;
  recording::Signal &w = r.signals["gyro"], &q = r.signals["attitude"];
  w.name = "gyro";
  q.name = "attitude";
  constexpr int n = 6000;
  w.values.resize(n, 3);
  q.values.resize(n, 4);
  Random random(5, "turning");
  Quat body = Quat::Identity();
  for (int i = 0; i < n; ++i) {
    const double t = 0.01 * i;
    const auto rate = [](double at) {
      return Vec3(0.5 * std::sin(4.4 * at) + 0.4 * std::sin(11.0 * at + 1), 0.6 * std::sin(7.1 * at),
                  0.4 * std::sin(3.1 * at + 2) + 0.3 * std::sin(14.0 * at));
    };
    w.t_s.push_back(t);
    q.t_s.push_back(0.012 + (1 + 400e-6) * t);
    for (int c = 0; c < 3; ++c) w.values(i, c) = rate(t)[c] + 0.02 * random.normal();
    q.values.row(i) << body.w(), body.x(), body.y(), body.z();
    body = (body * exp_rotation(0.01 * rate(t + 0.005))).normalized();
  }
  return r;
}

const Alignment* pair(const std::vector<Alignment>& all, const std::string& early, const std::string& late) {
  for (const Alignment& a : all)
    if (a.early == early && a.late == late) return &a;
  return nullptr;
}

TEST(Intake, MeasuresLagAndSkewOfTheAttitude) {
  const recording::Recording r = turning();
  const std::vector<Alignment> all = align_signals(r);
  const Alignment* a = pair(all, "gyro", "attitude");
  ASSERT_TRUE(a);
  // at the middle of the recording the skew has added 12 ms
  EXPECT_NEAR(a->lag_s, 0.024, 4 * a->lag_se + 0.001);
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
