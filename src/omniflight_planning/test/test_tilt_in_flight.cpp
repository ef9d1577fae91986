// Missions whose tilt moves on the way: checked at the tilt of each moment, by plan, certificate and verify.
#include <gtest/gtest.h>

#include "missions.hpp"
#include "omniflight_planning/flown.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

struct TiltInFlight : testing::Test {
  static void SetUpTestSuite() { use_shipped_configs(); }
};

/// In the middle of the frame, above the counter.
Result<Plan> planned(const std::string& name, const std::string& keys, const std::string& waypoints) {
  const auto mission = mission_of(
      "schema: omniflight.mission/1\nname: tilting\nvehicle: omnimorph\ntest_bed: pyramid\nclearance_m: 0.1\n"
      "limits: {speed_mps: 0.5, acceleration_mps2: 1, rate_dps: 45, angular_acceleration_dps2: 172" +
          keys + "start: {position: [0, 0, 1.2], hold_s: 0.5}\nwaypoints:\n" + waypoints,
      name);
  return mission ? plan_mission(*mission) : Result<Plan>(Failure(mission.error()));
}
Result<Plan> climbing(const std::string& name, const std::string& tilt = "in_flight",
                      const std::string& timing = "minimum_jerk") {
  return planned(
      name, ", rotor_headroom: 0.1}\nalpha_deg: 25\ntiming: " + timing + "\n",
      "  - {name: up, position: [0, 0, 1.5], attitude: {rpy_deg: [0, 25, 0]}, alpha_deg: 45, tilt: " + tilt +
          ", hold_s: 0.5}\n");
}

/// Tilts at which the vehicle holds an attitude with this payload and headroom, of every degree.
std::vector<int> tilts_that_hold(const vehicle::Vehicle& loaded, double pitch, double headroom) {
  std::vector<int> out;
  for (int degrees = 10; degrees <= 60; ++degrees) {
    const auto load = allocation::RotorLoad::create(loaded, to_radians(degrees)).value();
    if (load.hover_load(from_roll_pitch_yaw(Vec3(0, pitch, 0))) <= 1.0 - headroom) out.push_back(degrees);
  }
  return out;
}

TEST_F(TiltInFlight, MovesWithTheVehicleWithinTheServoAndVerifies) {
  const auto plan = climbing("with_the_vehicle");
  ASSERT_TRUE(plan) << plan.error().text();
  const vehicle::Vehicle v = omnimorph();
  const auto& knots = plan->trajectory.knots();
  double fastest = 0, before = 0, jerkiest = 0;
  int moving = 0;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const Reference &r = knots[k].reference, &next = knots[k + 1].reference;
    const double h = knots[k + 1].t - knots[k].t, rate = (next.alpha - r.alpha) / h;
    fastest = std::max(fastest, std::abs(rate));
    jerkiest = std::max(jerkiest, std::abs(rate - before) / h);
    before = rate;
    moving += rate > 0 && r.v_WB_W.norm() > 0.01;
    // the exact set of wrenches at the tilt of this very knot
    EXPECT_LE(rotor_load(v, r.alpha).motion_load(r), 0.9 + 1e-9) << knots[k].t;
  }
  EXPECT_GT(moving, 50);
  EXPECT_LE(fastest, 0.5 * v.tilt.rate + 1e-9);
  EXPECT_LT(jerkiest, 2.0);  // rad/s^2: the rate of the tilt has no steps
  EXPECT_NEAR(to_degrees(knots.back().reference.alpha), 45.0, 1e-9);
  const Certificate& c = plan->certificate;
  EXPECT_TRUE(c.tilts_in_flight);
  EXPECT_NEAR(c.peak_tilt_rate, fastest, 1e-9);
  EXPECT_NEAR(to_degrees(c.alpha_lowest), 25.0, 1e-9);
  EXPECT_NEAR(to_degrees(c.alpha_highest), 45.0, 1e-9);
  EXPECT_NE(explain(plan).find("in flight"), std::string::npos) << explain(plan);
  const fs::path dir = fs::path(testing::TempDir()) / "tilt_with_the_vehicle";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto read = read_plan(dir);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE(read->certificate.tilts_in_flight);
  EXPECT_NEAR(read->certificate.peak_tilt_rate, fastest, 1e-9);
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NEAR(report->peak.rotor_load, c.peak.rotor_load, 1e-9);
  EXPECT_GE(report->min_clearance, c.clearance_asked);
}

TEST_F(TiltInFlight, TakesLessTimeThanAtRest) {
  const auto flying = climbing("flying"), resting = climbing("resting", "at_rest");
  ASSERT_TRUE(flying) << flying.error().text();
  ASSERT_TRUE(resting) << resting.error().text();
  EXPECT_FALSE(resting->certificate.tilts_in_flight);
  EXPECT_LT(flying->certificate.duration, 0.8 * resting->certificate.duration);
}

TEST_F(TiltInFlight, TheShortestTimingKeepsTheServoAndTheRotorsOfEachTilt) {
  const auto smooth = climbing("smooth"), fast = climbing("fast", "in_flight", "shortest");
  ASSERT_TRUE(smooth) << smooth.error().text();
  ASSERT_TRUE(fast) << fast.error().text();
  EXPECT_EQ(fast->certificate.reason.find("does not apply"), std::string::npos) << fast->certificate.reason;
  const auto leg = [](const Plan& plan) { return plan.certificate.duration - 1.0; };  // less the holds
  EXPECT_LT(leg(*fast), 0.85 * leg(*smooth));
  const vehicle::Vehicle v = omnimorph();
  EXPECT_LE(fast->certificate.peak_tilt_rate, 0.5 * v.tilt.rate + 1e-9);
  EXPECT_GT(fast->certificate.peak_tilt_rate, 0.4 * v.tilt.rate) << "the servo is what holds it up";
  for (const TrajectoryKnot& k : fast->trajectory.knots())
    EXPECT_LE(rotor_load(v, k.reference.alpha).motion_load(k.reference), 0.9 + 1e-9) << k.t;
  const fs::path dir = fs::path(testing::TempDir()) / "tilt_fast";
  ASSERT_TRUE(write_plan(*fast, dir));
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_LE(report->peak.thrust_rate.share, 0.9);
}

TEST_F(TiltInFlight, HoldsAWayThatNoSingleTiltHolds) {
  const double headroom = 0.18;
  const vehicle::Vehicle loaded = carrying(omnimorph(), Payload{.mass = 0.685});
  // 30 and 60 degrees of pitch, both on the way, have no tilt in common
  const auto leaning = tilts_that_hold(loaded, to_radians(30), headroom);
  const auto far = tilts_that_hold(loaded, to_radians(60), headroom);
  ASSERT_FALSE(leaning.empty() || far.empty());
  ASSERT_LT(leaning.back(), far.front());
  for (const char* begin : {"20", "45"}) {
    const auto with = [&](const std::string& tilt) {
      return planned(
          std::string("no_single_") + begin + "_" + tilt,
          std::string(", rotor_headroom: 0.18}\npayload: {mass_kg: 0.685}\nalpha_deg: ") + begin + "\n",
          "  - {name: far, attitude: {rpy_deg: [0, 60, 0]}, alpha_deg: 60, tilt: " + tilt + "}\n");
    };
    EXPECT_FALSE(with("at_rest"));
    const auto plan = with("in_flight");
    ASSERT_TRUE(plan) << begin << ": " << plan.error().text();
    EXPECT_LE(plan->certificate.peak.rotor_load, 1.0 - headroom);
    const fs::path dir = fs::path(testing::TempDir()) / (std::string("tilt_no_single_") + begin);
    ASSERT_TRUE(write_plan(*plan, dir));
    const auto report = verify(dir);
    EXPECT_TRUE(report) << report.error().text();
    // sooner than the attitude allows, and no faster than the servo
    Plan bent = *plan;
    auto knots = bent.trajectory.knots();
    const double first = knots.front().reference.alpha;
    for (TrajectoryKnot& k : knots)
      k.reference.alpha = std::min(to_radians(60), first + to_radians(29) * std::max(0.0, k.t - 0.5));
    bent.trajectory = Trajectory::create(knots).value();
    ASSERT_TRUE(write_plan(bent, dir));
    const auto refusal = verify(dir);
    ASSERT_FALSE(refusal);
    EXPECT_NE(refusal.error().text().find("share of the rotors' range"), std::string::npos)
        << refusal.error().text();
  }
}

TEST_F(TiltInFlight, ItsClearanceIsThatOfTheTiltOfTheMoment) {
  const std::string keys = ", rotor_headroom: 0.1}\nalpha_deg: 25\n";
  const auto sinking = [&](const std::string& name, const std::string& height, const std::string& tilt) {
    return planned(name, keys, "  - {name: low, position: [0, 0, " + height + "], " + tilt + "}\n");
  };
  const std::string moving = "alpha_deg: 60, tilt: in_flight";
  const auto plan = sinking("sinking", "0.92", moving);
  ASSERT_TRUE(plan) << plan.error().text();
  const fs::path dir = fs::path(testing::TempDir()) / "tilt_sinking";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  // the lower rotors' rims over the counter, whose voxels end at 0.6 m
  const double rim = 0.92 - 0.125 - 0.1016 * std::sin(to_radians(60));
  std::vector<FlownPose> path;
  for (const TrajectoryKnot& k : plan->trajectory.knots())
    path.push_back({k.t, {k.reference.p_WB, k.reference.q_WB}, k.reference.alpha});
  const auto flown = flown_clearance(path, omnimorph(), kConfigs / "test_beds/pyramid.bt");
  ASSERT_TRUE(flown) << flown.error().text();
  EXPECT_NEAR(flown->least, rim - 0.6, 2e-3);
  // verify stops looking where what is left of the way cannot use up its room
  EXPECT_GE(report->min_clearance, 0.1);
  EXPECT_LT(report->min_clearance, 0.92 - 0.125 - 0.1016 * std::sin(to_radians(45)) - 0.6);
  // 2 cm lower there is room at the first tilt only
  EXPECT_TRUE(sinking("lower_at_first_tilt", "0.9", "hold_s: 0.1"));
  EXPECT_FALSE(sinking("lower", "0.9", moving));
}

TEST_F(TiltInFlight, AMoveThatCannotBeFlownIsRefusedWithItsReason) {
  const auto refused = [](const Result<Plan>& plan, const char* reason) {
    ASSERT_FALSE(plan) << reason;
    EXPECT_NE(plan.error().text().find(reason), std::string::npos) << plan.error().text();
  };
  const std::string keys = ", rotor_headroom: 0.1}\nalpha_deg: 25\n";
  refused(planned("far_tilt", keys, "  - {by: [0, 0, 0.2], alpha_deg: 75, tilt: in_flight}\n"),
          "alpha_out_of_range");
  refused(planned("parallel", keys, "  - {by: [0, 0, 0.2], alpha_deg: 0, tilt: in_flight}\n"),
          "tilt_in_flight");
  refused(planned("nowhere", keys, "  - {by: [0, 0, 0.2], tilt: in_flight}\n"), "nowhere to move to");
}

TEST_F(TiltInFlight, AChangedPlanIsRefused) {
  const auto plan = climbing("changed");
  ASSERT_TRUE(plan) << plan.error().text();
  const fs::path dir = fs::path(testing::TempDir()) / "tilt_changed";
  const auto refused = [&](const auto& change, const char* reason) {
    Plan bent = *plan;
    auto knots = bent.trajectory.knots();
    for (TrajectoryKnot& k : knots) change(k);
    bent.trajectory = Trajectory::create(knots).value();
    ASSERT_TRUE(write_plan(bent, dir));
    const auto report = verify(dir);
    ASSERT_FALSE(report) << reason;
    EXPECT_NE(report.error().text().find(reason), std::string::npos) << report.error().text();
  };
  const double end = plan->trajectory.duration();
  refused([&](TrajectoryKnot& k) { k.reference.alpha = to_radians(k.t < 0.5 * end ? 25 : 45); },
          "the servo does");
  refused([](TrajectoryKnot& k) { k.reference.alpha += to_radians(0.1); }, "not reached in its turn");
}

TEST_F(TiltInFlight, APlanFromAStateInFlightBeginsAtATiltThatRests) {
  const auto plan = climbing("from");
  ASSERT_TRUE(plan) << plan.error().text();
  const auto state = state_at(plan->trajectory, 0.5 * plan->trajectory.duration());
  ASSERT_FALSE(state);
  EXPECT_NE(state.error().text().find("tilt"), std::string::npos) << state.error().text();
  EXPECT_TRUE(state_at(plan->trajectory, 0.2));
}

}  // namespace
}  // namespace omniflight::planning
