// An accelerometer and motion capture that tell of one motion, and of two.
#include <gtest/gtest.h>

#include "../src/sensor_checks/lever_arm.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

test::Flown swaying() {
  test::Flown f;
  f.force_noise_N = 0;  // moves the accelerometer of this generator, not its position
  f.torque_noise_Nm = 0;
  f.sway = 0.3;
  return f;
}

Options told() {
  Options o;
  o.tolerance.accelerometer_lateral = o.tolerance.accelerometer_vertical = 0.005;
  o.tolerance.world_force = 0.0002;
  return o;
}

TEST(Kinematics, OneMotionShowsNothing) {
  const vehicle::Vehicle v = test::omnimorph();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::Flown f = swaying();
    f.seed = seed;
    const auto k = judge_kinematics(test::fly(v, {}, f), told());
    ASSERT_TRUE(k);
    EXPECT_GT(k->windows, 60);
    EXPECT_TRUE(k->parts.empty()) << k->parts.front().effect << " seed " << seed;
  }
}

TEST(Kinematics, ABiasIsFoundWithAnIntervalThatHoldsIt) {
  const vehicle::Vehicle v = test::omnimorph();
  const Vec3 bias(0.03, -0.04, 0.02);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::Flown f = swaying();
    f.seed = seed;
    recording::Recording r = test::fly(v, {}, f);
    r.signals["acc"].values.rowwise() += bias.transpose();
    const auto k = judge_kinematics(r, told());
    ASSERT_TRUE(k);
    ASSERT_EQ(k->parts.size(), 1u);
    EXPECT_EQ(k->parts[0].effect, "accelerometer_error");
    EXPECT_TRUE(k->parts[0].as_well.empty()) << "the vehicle leans, so its axes are not the world's";
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(k->parts[0].value[c], bias[c], std::min(0.01, 4 * k->parts[0].se[c])) << c;
  }
}

/// A nominal flight whose accelerometer sits at r_BI [m].
recording::Recording with_lever(const vehicle::Vehicle& v, const Vec3& r_BI) {
  const test::Flown f = swaying();
  recording::Recording r = test::fly(v, {}, f);
  auto& acc = r.signals["acc"];
  const double h = 1e-3;
  const auto arm = [&](double t) { return Vec3(test::attitude(t, f) * r_BI); };
  for (Eigen::Index i = 0; i < acc.values.rows(); ++i) {
    const double t = acc.t_s[static_cast<std::size_t>(i)];
    const Vec3 a_W = (arm(t + h) - 2 * arm(t) + arm(t - h)) / (h * h);
    acc.values.row(i) += (test::attitude(t, f).conjugate() * a_W).transpose();
  }
  return r;
}

/// What kinematics and forces together say.
Kinematics attributed(const recording::Recording& r, const vehicle::Vehicle& v) {
  auto k = judge_kinematics(r, told());
  auto flight = prepare_flight(r, v, told());
  EXPECT_TRUE(k && flight);
  if (!k || !flight) return {};
  attribute_lever(*flight, v, told(), *k);
  return *k;
}

TEST(Kinematics, ALeverArmIsFound) {
  const vehicle::Vehicle v = test::omnimorph();
  const Vec3 r_BI(0.05, 0, -0.03);
  const recording::Recording r = with_lever(v, r_BI);
  EXPECT_TRUE(attributed(r, v).find("imu_lever_arm"));
  const auto k = judge_kinematics(r, told());
  ASSERT_TRUE(k);
  const Kinematics::Part* lever = k->find("imu_lever_arm");
  ASSERT_TRUE(lever);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(lever->value[c], r_BI[c], 4 * lever->se[c] + 1e-4) << c;
}

TEST(Kinematics, MarkersOffTheOriginAreNoLeverArm) {
  const vehicle::Vehicle v = test::omnimorph();
  const test::Flown f = swaying();
  recording::Recording r = test::fly(v, {}, f);
  const Vec3 d(0.05, 0, -0.03);
  auto& position = r.signals["position"];
  for (Eigen::Index i = 0; i < position.values.rows(); ++i)
    position.values.row(i) += (test::attitude(position.t_s[static_cast<std::size_t>(i)], f) * d).transpose();
  const Kinematics k = attributed(r, v);
  EXPECT_FALSE(k.find("imu_lever_arm"));
  const Kinematics::Part* part = k.find("mocap_offset");
  ASSERT_TRUE(part);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(part->value[c], d[c], 4 * part->se[c] + 1e-4) << c;
}

/// A nominal flight, the world of motion capture turned by `by` [rad].
recording::Recording askew(double sway, const Vec3& by) {
  test::Flown f = swaying();
  f.sway = sway;
  recording::Recording r = test::fly(test::omnimorph(), {}, f);
  const Quat turn = exp_rotation(by);
  for (Eigen::Index i = 0; i < r.signals["position"].values.rows(); ++i) {
    r.signals["position"].values.row(i) = (turn * Vec3(r.signals["position"].values.row(i))).transpose();
    auto q = r.signals["attitude"].values.row(i);
    const Quat turned = turn * Quat(q[0], q[1], q[2], q[3]);
    q << turned.w(), turned.x(), turned.y(), turned.z();
  }
  return r;
}

TEST(Kinematics, ATiltThatIsABiasAsLargeAsToldIsNoFinding) {
  for (const double sway : {0.02, 0.1}) {
    const auto small = judge_kinematics(askew(sway, Vec3(0.0008, 0, 0)), told());  // 8 mm/s2, told to 5
    ASSERT_TRUE(small);
    EXPECT_TRUE(small->parts.empty()) << small->parts.front().effect << " at a sway of " << sway;
  }
  const auto large = judge_kinematics(askew(0.3, Vec3(0.003, 0, 0)), told());
  ASSERT_TRUE(large);
  ASSERT_EQ(large->parts.size(), 1u);
  EXPECT_EQ(large->parts[0].effect, "mocap_tilt");
}

TEST(Kinematics, ATiltedWorldIsFoundAndOnAnUprightFlightNotToldFromABias) {
  const auto tilted = [](double sway) {
    return judge_kinematics(askew(sway, Vec3(0.01, -0.006, 0)), told());
  };
  const auto leaning = tilted(0.4), upright = tilted(0);
  ASSERT_TRUE(leaning && upright);
  ASSERT_EQ(leaning->parts.size(), 1u);
  EXPECT_EQ(leaning->parts[0].effect, "mocap_tilt");
  EXPECT_NEAR(leaning->parts[0].value[0], 0.01, 0.001);
  EXPECT_NEAR(leaning->parts[0].value[1], -0.006, 0.001);
  ASSERT_EQ(upright->parts.size(), 1u);
  EXPECT_EQ(upright->parts[0].as_well.size(), 1u) << "a bias or a tilt: an upright flight cannot tell";
}

TEST(Kinematics, AToleranceOfNothingIsNoDivisionByIt) {
  Options exact = told();
  exact.tolerance.world_force = 0;
  const auto k = judge_kinematics(askew(0.3, Vec3(0.003, 0, 0)), exact);
  ASSERT_TRUE(k);
  ASSERT_EQ(k->parts.size(), 1u);
  EXPECT_EQ(k->parts[0].effect, "mocap_tilt");
  EXPECT_TRUE(k->parts[0].value.allFinite());
}

TEST(Kinematics, SignalsOfTwoBodiesAreNotJudged) {
  const vehicle::Vehicle v = test::omnimorph();
  recording::Recording r = test::fly(v, {}, swaying());
  r.signals["acc"].values *= -1;
  EXPECT_FALSE(judge_kinematics(r, told()));
  r.signals.erase("acc");
  EXPECT_FALSE(judge_kinematics(r, told()));
}

}  // namespace
}  // namespace omniflight::diagnosis
