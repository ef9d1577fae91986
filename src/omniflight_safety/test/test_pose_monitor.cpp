// What no pose may do to the estimate: blind it with a stamp, freeze it, or carry it away.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "omniflight_safety/pose_monitor.hpp"

namespace omniflight::safety {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
const Quat kLevel = Quat::Identity();

struct Monitored {
  PoseMonitor monitor{PoseMonitorConfig{}};
  double t = 10.0;
  /// A pose that moves by a hair with every call.
  std::optional<PoseRefusal> good() {
    t += 0.01;
    return monitor.judge(t, Vec3(0, 0, 1 + 1e-6 * t), kLevel, t, true, ExpectedPose{Vec3(0, 0, 1), kLevel});
  }
};

TEST(PoseMonitor, BelievesAPoseThatMovesAsTheVehicle) {
  Monitored m;
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(m.good());
  EXPECT_EQ(m.monitor.refused(), 0u);
}

TEST(PoseMonitor, AStampOfAnotherClockIsRefusedByItsSizeAndBlindsNobody) {
  Monitored m;
  EXPECT_FALSE(m.good());
  EXPECT_EQ(m.monitor.judge(1.73e9, Vec3(0, 0, 1), kLevel, m.t, true, {}), PoseRefusal::other_epoch);
  EXPECT_NE(m.monitor.last_words().find("1.73e+09 s"), std::string::npos) << m.monitor.last_words();
  EXPECT_EQ(m.monitor.judge(m.t + 3.0, Vec3(0, 0, 1), kLevel, m.t, true, {}), PoseRefusal::from_future);
  EXPECT_NE(m.monitor.last_words().find("3 s ahead"), std::string::npos) << m.monitor.last_words();
  EXPECT_FALSE(m.good());  // the next true pose is believed
}

TEST(PoseMonitor, PosesOfAUnixClockAreBelievedAtFlightTime) {
  Monitored m;
  int believed = 0;
  for (int k = 0; k < 100; ++k) {
    m.t += 0.01;
    const Vec3 p(0, 0, 1 + 1e-6 * k);
    if (m.monitor.judge(1.73e9 + m.t, p, kLevel, m.t + 0.008, true, {})) continue;
    ++believed;
    EXPECT_NEAR(m.monitor.believed_s(), m.t, 0.0081) << "to within the least delay";
  }
  EXPECT_GE(believed, 70);
  EXPECT_TRUE(m.monitor.clock().foreign());
}

TEST(PoseMonitor, OldAndRepeatedStampsAreRefused) {
  Monitored m;
  EXPECT_FALSE(m.good());
  EXPECT_EQ(m.monitor.judge(m.t - 0.7, Vec3(0, 0, 1), kLevel, m.t, true, {}), PoseRefusal::too_old);
  EXPECT_EQ(m.monitor.judge(m.t, Vec3(0, 0, 1), kLevel, m.t, true, {}), PoseRefusal::out_of_order);
  EXPECT_EQ(m.monitor.refused(PoseRefusal::too_old), 1u);
  EXPECT_EQ(m.monitor.refused(PoseRefusal::out_of_order), 1u);
}

TEST(PoseMonitor, EqualPosesInFreeFlightAreFrozen) {
  Monitored m;
  const auto same = [&](bool free) {
    m.t += 0.01;
    return m.monitor.judge(m.t, Vec3(1, 2, 3), kLevel, m.t, free, {});
  };
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(same(false)) << "held in place it may repeat itself";
  EXPECT_EQ(same(true), PoseRefusal::frozen);
  m.t += 0.01;
  EXPECT_FALSE(m.monitor.judge(m.t, Vec3(1, 2, 3.0001), kLevel, m.t, true, {}));
  m.t += 0.01;
  EXPECT_FALSE(
      m.monitor.judge(m.t, Vec3(1, 2, 3), Quat(Eigen::AngleAxisd(1e-6, Vec3::UnitZ())), m.t, true, {}));
  EXPECT_FALSE(same(true));  // equal in position alone is none, two equal ones may be chance
  EXPECT_FALSE(same(true));
  EXPECT_EQ(same(true), PoseRefusal::frozen);
}

TEST(PoseMonitor, JumpsAreRefusedAndAGapAllowsMore) {
  Monitored m;
  EXPECT_FALSE(m.good());
  const ExpectedPose here{Vec3(0, 0, 1), kLevel};
  EXPECT_EQ(m.monitor.judge(m.t + 0.01, Vec3(0.4, 0, 1), kLevel, m.t, true, here), PoseRefusal::jump);
  EXPECT_NE(m.monitor.last_words().find("0.4 m"), std::string::npos) << m.monitor.last_words();
  const Quat turned(Eigen::AngleAxisd(0.8, Vec3::UnitX()));
  EXPECT_EQ(m.monitor.judge(m.t + 0.02, Vec3(0, 0, 1), turned, m.t, true, here), PoseRefusal::jump);
  EXPECT_FALSE(m.monitor.judge(m.t + 0.4, Vec3(0.4, 0, 1), kLevel, m.t + 0.4, true, here));
}

TEST(PoseMonitor, AnEstimateThatRunsAwayFromSteadyPosesIsToldFromPosesThatLeap) {
  Monitored runs;
  EXPECT_FALSE(runs.good());
  for (int k = 1; k < 100; ++k) {  // the estimate leaves at 2 m/s, the poses stay
    runs.t += 0.01;
    runs.monitor.judge(runs.t, Vec3(0, 0, 1 + 1e-6 * k), kLevel, runs.t, true,
                       ExpectedPose{Vec3(0.02 * k, 0, 1), kLevel});
  }
  EXPECT_GT(runs.monitor.apart_m(), 1.9);
  EXPECT_GT(runs.monitor.refused(PoseRefusal::jump), 50u);

  Monitored turns;
  EXPECT_FALSE(turns.good());
  turns.t += 0.01;
  turns.monitor.judge(turns.t, Vec3(0, 0, 1.001), kLevel, turns.t, true,
                      ExpectedPose{Vec3(0, 0, 1), Quat(Eigen::AngleAxisd(0.9, Vec3::UnitX()))});
  EXPECT_NEAR(turns.monitor.apart_m(), 0.9, 1e-9) << "an arm of 1 m for the attitude";

  Monitored leaps;
  EXPECT_FALSE(leaps.good());
  for (int k = 1; k < 100; ++k) {
    leaps.t += 0.01;
    leaps.monitor.judge(leaps.t, Vec3(5, 0, 1 + 1e-6 * k), kLevel, leaps.t, true,
                        ExpectedPose{Vec3(0, 0, 1), kLevel});
  }
  EXPECT_EQ(leaps.monitor.apart_m(), 0.0) << "no vehicle moves 5 m in 10 ms";
  EXPECT_FALSE(leaps.good());
  EXPECT_LT(leaps.monitor.apart_m(), 0.01);
}

TEST(PoseMonitor, WhatIsNoNumberIsRefused) {
  Monitored m;
  EXPECT_EQ(m.monitor.judge(kNaN, Vec3(0, 0, 1), kLevel, m.t, true, {}), PoseRefusal::not_finite);
  EXPECT_EQ(m.monitor.judge(m.t, Vec3(kNaN, 0, 1), kLevel, m.t, true, {}), PoseRefusal::not_finite);
  EXPECT_EQ(m.monitor.judge(m.t, Vec3(0, 0, 1), Quat(0, 0, 0, 0), m.t, true, {}), PoseRefusal::not_finite);
  EXPECT_EQ(m.monitor.judge(m.t, Vec3(0, 0, 1), Quat(kNaN, 0, 0, 0), m.t, true, {}), PoseRefusal::not_finite);
  EXPECT_EQ(m.monitor.judge(m.t, Vec3(0, 0, 1), kLevel, kNaN, true, {}), PoseRefusal::not_finite);
  EXPECT_EQ(m.monitor.refused(), 5u);
}

TEST(PoseMonitor, EveryReasonHasAName) {
  std::string all;
  for (std::size_t k = 0; k < kPoseRefusals; ++k) {
    const auto name = to_string(static_cast<PoseRefusal>(k));
    EXPECT_EQ(all.find(name), std::string::npos);
    all += std::string(name) + " ";
  }
}

}  // namespace
}  // namespace omniflight::safety
