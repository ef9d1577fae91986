// Maps that are drafted from the columns of a CSV: they load, and name what was guessed.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "omniflight_core/frames.hpp"
#include "omniflight_recording/formats.hpp"
#include "omniflight_recording/map_draft.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

class MapDrafts : public testing::Test {
 protected:
  fs::path file = fs::temp_directory_path() / ("omniflight_draft_" + std::to_string(::getpid()));
  fs::path map = file.string() + ".yaml";
  void TearDown() override {
    fs::remove(file);
    fs::remove(map);
  }
  Result<MapDraft> draft(const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
    auto out = draft_csv_map(file);
    if (out) std::ofstream(map) << out->yaml;
    return out;
  }
  Recording read() {
    const auto r = load(file, {.map = map});
    EXPECT_TRUE(r) << (r ? "" : r.error().text());
    return r ? *r : Recording{};
  }
};

TEST_F(MapDrafts, UnitsAreTakenFromNamesAndSizes) {
  const auto d = draft(
      "Time [ms];imu_gyro_x [\xc2\xb0/s];imu_gyro_y [\xc2\xb0/s];imu_gyro_z "
      "[\xc2\xb0/s];acc.x;acc.y;acc.z;qx;qy;qz;qw;rpm1;rpm2;"
      "pwm_1;pwm_2;Vbat;remark\n0;90;0;-90;0;0;1,0;0;0;0;1;3000;3100;1500;2000;11100;a\n"
      "10;90;0;-90;0;0;1,1;0;0;0;1;3000;3100;1500;2000;11000;b\n");
  ASSERT_TRUE(d) << d.error().text();
  const auto r = read();
  EXPECT_EQ(r.find("gyro")->t_s[1], 0.01);
  EXPECT_NEAR(r.find("gyro")->values(0, 2), -kPi / 2, 1e-12);
  EXPECT_NEAR(r.find("acc")->values(0, 2), kGravity, 1e-12);
  EXPECT_EQ(r.find("attitude")->values(0, 0), 1);
  EXPECT_NEAR(r.find("rotor_speed")->values(0, 1), 3100 * kPi / 30, 1e-9);
  EXPECT_NEAR(r.find("pwm")->values(0, 0), 0.5, 1e-12);
  EXPECT_NEAR(r.find("vbat")->values(0, 0), 11.1, 1e-12);
  EXPECT_EQ(d->unused, std::vector<std::string>{"'remark', no number"});
  EXPECT_EQ(d->guessed.front(), "time [s] from 'Time [ms]', ms by its name");
}

TEST_F(MapDrafts, TheStepOfATimeWithoutUnitTellsIt) {
  const auto scale = [&](const std::string& a, const std::string& b) {
    const auto d = draft("timestamp,x,y,z\n" + a + ",0,0,1\n" + b + ",0,0,1\n");
    return d ? read().find("position")->t_s.back() - read().find("position")->t_s.front() : -1.0;
  };
  EXPECT_NEAR(scale("0", "0.01"), 0.01, 1e-12);
  EXPECT_NEAR(scale("0", "10"), 0.01, 1e-12);
  EXPECT_NEAR(scale("0", "10000"), 0.01, 1e-12);
  EXPECT_NEAR(scale("0", "10000000"), 0.01, 1e-12);
}

TEST_F(MapDrafts, WhatCannotBeGuessedIsSaid) {
  const auto refusal = [&](const std::string& text) {
    const auto d = draft(text);
    return d ? "drafted" : d.error().text();
  };
  EXPECT_NE(refusal("x,y,z\n0,0,1\n").find("no column that looks like a time"), std::string::npos);
  EXPECT_NE(refusal("t,foo\n0,1\n").find("no columns whose names are known"), std::string::npos);
  EXPECT_NE(refusal("t\xff,x,y,z\n0,0,0,1\n").find("no column that looks like a time"), std::string::npos);
  EXPECT_NE(refusal("nothing").find("is no CSV"), std::string::npos);
}

TEST_F(MapDrafts, HostileHeadersAreDraftedOrRefused) {
  const std::string text = "t [s],gyro_x,gyro_y,gyro_z,\"a, \\ \"\"b\",m1,m2\n0,0,0,1,2,3,4\n1,0,0,1,2,3,4\n";
  std::mt19937_64 random(3);
  for (int i = 0; i < 3000; ++i) {
    std::string changed = text;
    for (int k = 0; k < 3; ++k) changed[random() % changed.size()] = static_cast<char>(random());
    if (!draft(changed)) continue;
    const auto r = load(file, {.map = map});  // the map is sound; the table need not be
    if (!r) {
      EXPECT_EQ(r.error().text().find(map.string()), std::string::npos) << r.error().text();
    }
  }
}

}  // namespace
