// Tracking errors and gusts as a margin beyond the clearance.
#include "omniflight_planning/tube.hpp"

#include <gtest/gtest.h>

#include "missions.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

struct Tubes : testing::Test {
  static void SetUpTestSuite() { setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1); }
};

std::string flight_json(const std::string& position, const std::string& degrees,
                        const std::string& complete = "true") {
  return R"({"schema": "omniflight.flight/1", "complete": )" + complete +
         R"(, "metrics": {"measured": {"worst_position_m": )" + position + R"(, "worst_attitude_deg": 1},
             "true": {"worst_position_m": 0.001, "worst_attitude_deg": )" +
         degrees + "}}}";
}

Result<Mission> with_keys(const std::string& keys, const std::string& name) {
  return mission_of(trajectory_2_with(keys), name);
}

/// From one side of a slot of `width` to the other.
Mission through_the_wall() {
  Mission mission;
  mission.name = "through";
  mission.alpha = to_radians(30);
  mission.clearance = 0.02;
  mission.budget_s = 3.0;
  mission.waypoints = {{.name = "here", .pose = {Vec3(-1.0, 0, 1.2), Quat::Identity()}, .where = {}},
                       {.name = "there", .pose = {Vec3(1.05, 0, 1.2), Quat::Identity()}, .where = {}}};
  return mission;
}

TEST_F(Tubes, TheLargestErrorOfAFlightIsRead) {
  const auto tube = read_tube(written("tube_flight.json", flight_json("0.031", "2.5")));
  ASSERT_TRUE(tube) << tube.error().text();
  EXPECT_NEAR(tube->position, 0.031, 1e-12);
  EXPECT_NEAR(tube->attitude, to_radians(2.5), 1e-12);
  EXPECT_NEAR(tube->margin(0.4), 0.031 + to_radians(2.5) * 0.4, 1e-12);
  const auto compared = read_tube(written("tube_compare.json",
                                          R"({"schema": "omniflight.compare/1", "tracking": {
           "simulated": {"measured": {"worst_position_m": 0.01, "worst_attitude_deg": 1}},
           "real": {"measured": {"worst_position_m": 0.2, "worst_attitude_deg": 4}}}})"));
  ASSERT_TRUE(compared) << compared.error().text();
  EXPECT_NEAR(compared->position, 0.2, 1e-12);
}

TEST_F(Tubes, WhatTellsNoErrorIsRefused) {
  const auto refused = [](const std::string& bytes, const std::string& words) {
    const auto tube = read_tube(written("tube_bad.json", bytes));
    ASSERT_FALSE(tube) << bytes;
    EXPECT_EQ(tube.error().code, ErrorCode::bad_input);
    EXPECT_NE(tube.error().text().find(words), std::string::npos) << tube.error().text();
  };
  refused("", "no JSON object");
  refused(flight_json("0.03", "2").substr(0, 60), "no JSON object");
  refused("[1, 2]", "no JSON object");
  refused(R"({"schema": "omniflight.gains/1"})", "omniflight.gains/1");
  refused(R"({"schema": 3})", "schema");
  refused(R"({"schema": "omniflight.flight/1", "complete": true, "metrics": 3})", "metrics");
  refused(R"({"schema": "omniflight.flight/1", "complete": true})", "position error");
  refused(R"({"schema": "omniflight.compare/1", "tracking": []})", "position error");
  refused(flight_json("0.03", "2", "false"), "ended early");
  refused(flight_json("-0.03", "2"), "position error");
  refused(flight_json("\"0.03\"", "2"), "position error");
  refused(flight_json("50", "2"), "position error");
  refused(flight_json("0.03", "null"), "attitude error");
  EXPECT_FALSE(read_tube("/nowhere/flight.json"));
}

TEST_F(Tubes, ASlotMustHaveRoomForTheErrorsToo) {
  const auto tree = make_octree(window_bed(1.2, 2.4, 0.05)).value();
  const DistanceMap map = DistanceMap::create(*tree, "").value();
  const Mission mission = through_the_wall();
  const auto free = plan(mission, omnimorph(), map);
  ASSERT_TRUE(free) << free.error().text();
  EXPECT_FALSE(free->certificate.tube.in_margin);
  PlanOptions options;
  options.tube_file = written("tube_small.json", flight_json("0.03", "2"));
  const auto kept = plan(mission, omnimorph(), map, options);
  ASSERT_TRUE(kept) << kept.error().text();
  EXPECT_TRUE(kept->certificate.tube.in_margin);
  const double margin = kept->certificate.tube.margin(omnimorph().bounding_radius());
  EXPECT_GT(margin, 0.03);
  EXPECT_GE(kept->certificate.min_clearance, mission.clearance + margin);
  options.tube_file = written("tube_large.json", flight_json("0.42", "2"));
  const auto none = plan(mission, omnimorph(), map, options);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().code, ErrorCode::bad_input) << none.error().text();
  options.tube_file = written("tube_huge.json", flight_json("0.6", "2"));
  const auto refused = plan(mission, omnimorph(), map, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("margin_too_large"), std::string::npos) << refused.error().text();
}

TEST_F(Tubes, VerifyKeepsTheMarginAndTheFileItCameFrom) {
  const auto mission = load_mission("trajectory_2");
  ASSERT_TRUE(mission);
  PlanOptions options;
  const fs::path file = written("tube_verified.json", flight_json("0.015", "1"));
  options.tube_file = file;
  auto plan = plan_mission(*mission, options);
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_NE(explain(plan).find("off its reference"), std::string::npos) << explain(plan);
  const fs::path dir = fs::path(testing::TempDir()) / "tube_verified";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  const auto again = read_plan(dir);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->certificate.tube.sha256, plan->certificate.tube.sha256);
  EXPECT_NEAR(again->certificate.tube.position, 0.015, 1e-12);
  EXPECT_TRUE(again->certificate.tube.in_margin);
  // a flight that was worse than what the plan kept
  const auto worse = read_tube(written("tube_worse.json", flight_json("0.9", "3")));
  ASSERT_TRUE(worse);
  plan->certificate.tube = *worse;
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto near = verify(dir);
  ASSERT_FALSE(near);
  EXPECT_NE(near.error().text().find("comes within"), std::string::npos) << near.error().text();
  // a certificate that tells another value than its file
  plan->certificate.tube.position = 0.01;
  ASSERT_TRUE(write_plan(*plan, dir));
  ASSERT_FALSE(verify(dir));
  // a file that was written again
  plan->certificate.tube = *read_tube(file);
  ASSERT_TRUE(write_plan(*plan, dir));
  ASSERT_TRUE(verify(dir));
  written("tube_verified.json", flight_json("0.014", "1"));
  const auto changed = verify(dir);
  ASSERT_FALSE(changed);
  EXPECT_NE(changed.error().text().find("have changed"), std::string::npos) << changed.error().text();
}

TEST_F(Tubes, AGustAddsItsWayAndNeedsTrackingErrors) {
  const auto alone = with_keys("tracking: {gust_N: 2, compliance_m_per_N: 0.01}", "gust_alone");
  ASSERT_TRUE(alone) << alone.error().text();
  const auto refused = plan_mission(*alone);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
  EXPECT_NE(refused.error().text().find("tracking.position_m"), std::string::npos);
  const auto gusty = with_keys(
      "tracking: {position_m: 0.01, attitude_deg: 1, gust_N: 2, compliance_m_per_N: 0.004}", "gust_told");
  ASSERT_TRUE(gusty) << gusty.error().text();
  const auto plan = plan_mission(*gusty);
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_NEAR(plan->certificate.tube.position, 0.018, 1e-12);
  EXPECT_TRUE(plan->certificate.tube.in_margin);
  const auto without = with_keys("tracking: {position_m: 0.03, attitude_deg: 3}", "no_gust");
  EXPECT_FALSE(tube_of(*without, omnimorph()).in_margin);  // as before: a bound for the flight alone
  const auto asked = with_keys("tracking: {position_m: 0.03, attitude_deg: 3, in_margin: true}", "in_margin");
  ASSERT_TRUE(asked) << asked.error().text();
  EXPECT_TRUE(tube_of(*asked, omnimorph()).in_margin);
}

TEST_F(Tubes, ATetherIsLongEnoughOffTheReferenceToo) {
  const auto mission = with_keys("tether: {anchor: [0, 0, 0.58], length_m: 1.6}", "tube_tether");
  ASSERT_TRUE(mission);
  ASSERT_TRUE(plan_mission(*mission));  // 1.45 m are used
  PlanOptions options;
  options.tube_file = written("tube_tether.json", flight_json("0.2", "1"));
  const auto plan = plan_mission(*mission, options);
  ASSERT_FALSE(plan);
  EXPECT_NE(plan.error().text().find("tether"), std::string::npos) << plan.error().text();
}

}  // namespace
}  // namespace omniflight::planning
