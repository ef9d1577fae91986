// The rate of thrust that the lag of the motors allows: the bound, rides that keep it, and its verification.
#include <gtest/gtest.h>

#include <iostream>

#include "missions.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_planning/rotors.hpp"
#include "omniflight_planning/timing.hpp"

namespace omniflight::planning {
namespace {

/// OmniMorph with motors of another lag [s].
vehicle::Vehicle with_lag(double seconds) {
  vehicle::Vehicle v = omnimorph();
  for (auto& rotor : v.rotors) rotor.time_constant = seconds;
  return v;
}

/// Thrust [N] after `seconds` of a motor commanded to a thrust, by integration of its lag.
double integrated(const vehicle::Rotor& rotor, double thrust, double command, double seconds) {
  constexpr int kSteps = 20'000;
  double w = rotor.speed(thrust);
  for (int i = 0; i < kSteps; ++i) w += seconds / kSteps * (rotor.speed(command) - w) / rotor.time_constant;
  return rotor.thrust(w);
}

TEST(ReachableThrusts, AreThoseOfAMotorCommandedToTheEndsOfItsRange) {
  vehicle::Rotor rotor = omnimorph().rotors[0];
  for (const bool bidirectional : {true, false}) {
    rotor.bidirectional = bidirectional;
    for (const double thrust : {0.2, 1.0, 4.0, 6.2})
      for (const double seconds : {0.001, 0.01, 0.1}) {
        const auto reach = reachable_thrusts(rotor, thrust, seconds);
        EXPECT_NEAR(reach.high, integrated(rotor, thrust, rotor.max_thrust, seconds), 2e-3);
        EXPECT_NEAR(reach.low, integrated(rotor, thrust, rotor.lower_thrust(), seconds), 2e-3);
      }
  }
}

TEST(ReachableThrusts, TendToTheRateOfTheEquationForSmallSteps) {
  const vehicle::Rotor rotor = omnimorph().rotors[0];
  const double f = 2.0, w = rotor.speed(f), h = 1e-6;
  const double rate = 2.0 * rotor.thrust_coefficient * w * (rotor.max_speed() - w) / rotor.time_constant;
  EXPECT_NEAR((reachable_thrusts(rotor, f, h).high - f) / h, rate, 1e-3 * rate);
}

TEST(Rotors, AChangeToTheEndOfTheReachNeedsAllOfTheRate) {
  const auto v = omnimorph();
  const auto rotors = rotors_of(v, to_radians(45));
  vehicle::RotorVector from = vehicle::RotorVector::Constant(8, 1.0), to = from;
  to[4] = reachable_thrusts(v.rotors[4], 1.0, 0.01).low;
  const ThrustRate all = rotors.rate(from, to, 0.01);
  EXPECT_NEAR(all.share, 1.0, 0.01);  // less a change that counts as none
  EXPECT_EQ(all.rotor, 5);
  EXPECT_EQ(rotors_of(with_lag(0), to_radians(45)).rate(from, to, 0.01).share, 0.0);
}

TEST(Rotors, ThrustsGiveTheWrenchAndLeaveTheHeadroom) {
  const auto v = omnimorph();
  const auto rotors = rotors_of(v, to_radians(45));
  Rotors::Thrusts thrusts(rotors);
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    Reference r;
    r.q_WB = exp_rotation(Vec3(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)));
    r.a_WB_W = Vec3(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-4, 4));
    const Vec6 wrench = rotors.load().required_wrench(r);
    const auto u = thrusts.of(wrench);
    EXPECT_LE(u.cwiseAbs().maxCoeff(), 0.9 * 6.25 + 1e-9);
    if (rotors.load().load(wrench) > 0.9) continue;
    EXPECT_LT((v.allocation_matrix(to_radians(45)) * u - wrench).norm(), 1e-4);
  }
}

TEST(Rotors, ThrustsAreThoseOfTheWholeProgramWithinTheBoundsAndAtThem) {
  constexpr double kWeight = 1e7;
  const auto v = omnimorph();
  const auto rotors = rotors_of(v, to_radians(50));
  const auto B = v.allocation_matrix(to_radians(50));
  allocation::QpMatrix H = kWeight * B.transpose() * B;
  H.diagonal().array() += 1.0;
  const allocation::QpVector most = allocation::QpVector::Constant(8, 0.9 * 6.25);
  Rotors::Thrusts thrusts(rotors);
  Random random(8);
  int bounded = 0;
  for (int trial = 0; trial < 300; ++trial) {
    allocation::QpVector some(8);
    const double size = random.uniform(0.5, 8.0);
    for (int k = 0; k < 8; ++k) some[k] = random.uniform(-size, size);
    const Vec6 wrench = B * some;
    const auto whole = allocation::solve_box_qp(H, -kWeight * B.transpose() * wrench, -most, most);
    ASSERT_EQ(whole.status, allocation::QpStatus::solved);
    bounded += whole.active_bounds > 0;
    EXPECT_LT((thrusts.of(wrench) - whole.u).cwiseAbs().maxCoeff(), 1e-6) << trial;
  }
  EXPECT_GT(bounded, 20);
  EXPECT_LT(bounded, 280);
}

TEST(Ride, IsSlowerForMotorsThatLagAndKeepsTheirRate) {
  const Pose level{Vec3(0, 0, 1), Quat::Identity()},
      rolled{Vec3(0.6, 0.2, 1.1), exp_rotation(Vec3(2.5, 0, 0))};
  const PoseCurve curve({level, rolled});
  const MotionLimits limits{.speed = 20, .acceleration = 50, .rate = 20, .angular_acceleration = 200};
  double before = 0.0;
  for (const double lag : {0.0, 0.015, 0.05, 0.2}) {
    const auto rotors = rotors_of(with_lag(lag), to_radians(50));
    const auto knots = ride(curve, rotors, limits);
    ASSERT_TRUE(knots) << knots.error().text();
    const MotionPeaks p = peaks(*knots, rotors);
    EXPECT_LE(p.thrust_rate.share, 0.9);
    EXPECT_LE(p.rotor_load, 0.9);
    EXPECT_GE(knots->back().t, before);
    if (lag > 0.02) {
      EXPECT_GT(knots->back().t, before + 0.05) << lag;
      EXPECT_GT(p.thrust_rate.share, 0.6) << "the lag is what the ride waits for";
    }
    before = knots->back().t;
  }
}

/// The YAML of trajectory_2 with limits that leave it to the rotors, and further keys.
std::string fast_trajectory_2(const std::string& keys) {
  std::string yaml = trajectory_2_with(keys);
  const std::size_t at = yaml.find("limits:");
  return yaml.replace(
      at, yaml.find('\n', at) - at,
      "limits: {speed_mps: 5, acceleration_mps2: 20, rate_dps: 600, angular_acceleration_dps2: 6000}");
}

TEST(Verify, NamesTheRotorThatWouldHaveToBeFasterThanItsLag) {
  use_shipped_configs();
  const std::string yaml = fast_trajectory_2("");
  const auto mission = mission_of(yaml, "fast");
  ASSERT_TRUE(mission) << mission.error().text();
  auto plan = plan_mission(*mission);
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_GT(plan->certificate.peak.thrust_rate.rotor, 0);
  EXPECT_NE(explain(plan).find("of the rate of thrust that its lag allows"), std::string::npos);
  const auto dir = std::filesystem::path(testing::TempDir()) / "lag";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NEAR(report->peak.thrust_rate.share, plan->certificate.peak.thrust_rate.share, 1e-6);
  EXPECT_NEAR(read_plan(dir)->certificate.peak.thrust_rate.share, report->peak.thrust_rate.share, 1e-6);

  // the same flight, said to be one of a vehicle with slower motors
  Certificate& c = plan->certificate;
  c.vehicle_set = {"rotors.time_constant=0.3"};
  const auto slow = vehicle::load_vehicle(c.vehicle_file, c.vehicle_set);
  ASSERT_TRUE(slow) << slow.error().text();
  c.vehicle_sha256 = slow->sha256;
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto refused = verify(dir);
  ASSERT_FALSE(refused);
  for (const char* part : {"rotor ", "of the rate of thrust that its lag allows", " s with the vehicle at ("})
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().text();
}

TEST(Plan, ShortestTimingIsShorterAndVerifies) {
  use_shipped_configs();
  std::string yaml = files::read_file(kConfigs / "missions/around_frame.yaml", 1 << 20).value();
  const auto smooth = plan_mission(mission_of(yaml, "smooth").value());
  yaml.insert(yaml.find("start: {position"), "timing: shortest\n");
  const auto shortest = plan_mission(mission_of(yaml, "shortest").value());
  ASSERT_TRUE(shortest) << shortest.error().text();
  EXPECT_LT(shortest->certificate.duration, 0.8 * smooth->certificate.duration);
  std::cout << smooth->certificate.duration << " s by minimum jerk\n" << explain(shortest);
  EXPECT_LE(shortest->certificate.peak.speed, shortest->certificate.limits.speed);
  EXPECT_LE(shortest->certificate.peak.thrust_rate.share, 0.9);
  const auto dir = std::filesystem::path(testing::TempDir()) / "shortest";
  ASSERT_TRUE(write_plan(*shortest, dir));
  const auto report = verify(dir);
  EXPECT_TRUE(report) << report.error().text();
}

TEST(Plan, AnUnknownTimingIsRefusedWithTheKnownOnes) {
  const auto mission = mission_of(fast_trajectory_2("timing: fastest"), "unknown_timing");
  ASSERT_FALSE(mission);
  EXPECT_NE(mission.error().text().find("minimum_jerk"), std::string::npos) << mission.error().text();
}

}  // namespace
}  // namespace omniflight::planning
