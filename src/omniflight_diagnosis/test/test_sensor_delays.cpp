// One cause for the delays of the gyro behind pose and rotors.
#include <gtest/gtest.h>

#include <cmath>

#include "../src/conditioning/sensor_delays.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

GyroDelays delays(double behind_pose_s, double behind_rotors_s) {
  GyroDelays out;
  if (std::isfinite(behind_pose_s)) out.behind_pose = Alignment{"attitude", "gyro", behind_pose_s, 5e-4};
  if (std::isfinite(behind_rotors_s)) out.behind_rotors = TorqueLag{behind_rotors_s, 3e-4, 0.95};
  return out;
}

std::string named(const GyroDelays& d) {
  const auto late = what_is_late(d, test::omnimorph(), {});
  return late ? late->effect : "";
}

TEST(SensorDelays, EachPairOfDelaysHasItsCause) {
  EXPECT_EQ(named(delays(0.03, 0.0)), "clock_offset");
  EXPECT_EQ(named(delays(-0.03, 0.0)), "clock_offset");
  EXPECT_EQ(named(delays(0.03, 0.03)), "sensor_filter");
  EXPECT_EQ(named(delays(0.0, 0.03)), "dynamic_inflow");
}

TEST(SensorDelays, WhatClocksMayDoIsNoFinding) {
  EXPECT_EQ(named(delays(0.004, 0.002)), "");
  EXPECT_EQ(named(delays(NAN, NAN)), "");
}

TEST(SensorDelays, RotorsThatAnswerToTheMotionAreNoFinding) { EXPECT_EQ(named(delays(0.0, -0.02)), ""); }

TEST(SensorDelays, WithoutPoseFilterAndThrustAreRivals) {
  const auto late = what_is_late(delays(NAN, 0.03), test::omnimorph(), {});
  ASSERT_TRUE(late);
  ASSERT_EQ(late->rivals.size(), 1u);
  EXPECT_TRUE(late->effect == "sensor_filter" ? late->rivals[0] == "dynamic_inflow"
                                              : late->rivals[0] == "sensor_filter");
}

TEST(SensorDelays, WhatSmoothsIsNoClock) {
  GyroDelays d = delays(0.03, NAN);
  EXPECT_EQ(what_is_late(d, test::omnimorph(), {})->rivals.size(), 1u);
  d.as_response = ThrustResponse{.time = 0.03, .time_se = 1e-3, .lead = -1, .log_factor = 50};
  const auto late = what_is_late(d, test::omnimorph(), {});
  ASSERT_TRUE(late);
  EXPECT_EQ(late->effect, "sensor_filter");
  EXPECT_TRUE(late->rivals.empty());
}

}  // namespace
}  // namespace omniflight::diagnosis
