// A tether in the plan: length, way of the segment, cone, twist and weight.
#include "omniflight_planning/tether.hpp"

#include <gtest/gtest.h>

#include "missions.hpp"
#include "omniflight_planning/flown.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

struct Tethers : testing::Test {
  static void SetUpTestSuite() { setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1); }
};

Result<Mission> with_tether(const std::string& keys, const std::string& name = "tethered") {
  return mission_of(trajectory_2_with("tether: {" + keys + "}"), name);
}

TEST_F(Tethers, ShorterThanTheWayIsRefusedWithMetres) {
  const auto mission = with_tether("anchor: [0, 0, 0.58], length_m: 1.2");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto plan = plan_mission(*mission);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::bad_input);
  EXPECT_NE(plan.error().text().find("tether_too_short: full height"), std::string::npos)
      << plan.error().text();
  EXPECT_NE(plan.error().text().find("1.200 m"), std::string::npos) << plan.error().text();
  EXPECT_NE(plan.error().text().find("1.420 m"), std::string::npos) << plan.error().text();
}

TEST_F(Tethers, PlanVerifiesAndItsCertificateTellsTheUse) {
  const auto mission = with_tether("anchor: [0, 0, 0.58], length_m: 1.6, mass_kg_per_m: 0.03", "told");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto plan = plan_mission(*mission);
  ASSERT_TRUE(plan) << plan.error().text();
  ASSERT_TRUE(plan->certificate.tether);
  // sideways by 0.3 m, 1.42 m above the anchor
  EXPECT_NEAR(plan->certificate.tether->longest, std::hypot(0.3, 1.42), 1e-3);
  EXPECT_NEAR(plan->certificate.tether->mass, 0.048, 1e-12);
  const fs::path dir = fs::path(testing::TempDir()) / "tether_told";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  const auto again = read_plan(dir);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_NEAR(again->certificate.tether->longest, plan->certificate.tether->longest, 1e-9);
  // the weight is in the rotors' share
  auto bare = *mission;
  bare.tether.reset();
  EXPECT_GT(plan->certificate.peak.rotor_load, plan_mission(bare)->certificate.peak.rotor_load + 0.005);
}

TEST_F(Tethers, VerifyMeasuresTheTetherItselfAndSaysWhichPartFails) {
  const struct {
    const char *name, *keys, *words;
  } cases[] = {
      {"length", "anchor: [0, 0, 0.58], length_m: 1.3", "the tether of 1.300 m is shorter than the way"},
      {"cone", "anchor: [0, 0, 0.58], length_m: 1.6, cone_axis: [0, 0, -1], cone_deg: 6",
       "its cone of 6.0 deg"},
      {"segment", "anchor: [0, 0, 0.1], length_m: 2.5", "the tether comes within 0.000 m of the voxels"}};
  for (const auto& c : cases) {
    const auto tight = with_tether(c.keys, std::string("measured_") + c.name);
    ASSERT_TRUE(tight) << tight.error().text();
    auto forgotten = *tight;  // by a planner
    forgotten.tether.reset();
    const auto plan = plan_mission(forgotten);
    ASSERT_TRUE(plan) << plan.error().text();
    const fs::path dir = fs::path(testing::TempDir()) / (std::string("tether_") + c.name);
    ASSERT_TRUE(write_plan(*plan, dir));
    const auto report = verify(dir);
    ASSERT_FALSE(report) << c.name;
    EXPECT_NE(report.error().message.find(c.words), std::string::npos) << report.error().message;
    EXPECT_NE(report.error().message.find(" s with the vehicle at ("), std::string::npos)
        << report.error().message;
  }
}

TEST_F(Tethers, MotionsThatDrawTheTetherThroughAPoleAreInvalid) {
  const DistanceMap map = pole_room(0.04);
  const StateCheck alone = make_check(map, 30, 0.05);
  Tether tether;
  tether.anchor_W = Vec3(-1.5, 0, 0.2);
  tether.length = 4.0;
  const StateCheck tied = alone.with_tether(tether);
  const Pose left{Vec3(1.2, 0.9, 1.2), Quat::Identity()}, right{Vec3(1.2, -0.9, 1.2), Quat::Identity()};
  ASSERT_TRUE(alone.motion_valid(left, right));
  EXPECT_TRUE(tied.valid(left) && tied.valid(right));
  EXPECT_FALSE(tied.motion_valid(left, right));
  const Pose up{Vec3(1.2, 0.9, 1.8), Quat::Identity()};
  EXPECT_TRUE(tied.motion_valid(left, up));
}

TEST_F(Tethers, LengthAndConeHoldAlongWholeMotions) {
  const DistanceMap map = pole_room(0.04);
  Tether tether;
  tether.anchor_W = Vec3(1.2, 0, 0);
  tether.length = 1.5;
  const StateCheck alone = make_check(map, 30, 0.05), tied = alone.with_tether(tether);
  const auto at = [](double y, double z, double roll_deg = 0) {
    return Pose{Vec3(1.2, y, z), from_roll_pitch_yaw(Vec3(to_radians(roll_deg), 0, 0))};
  };
  EXPECT_TRUE(tied.motion_valid(at(-0.8, 1.1), at(0.8, 1.1)));
  EXPECT_FALSE(tied.valid(at(0.8, 1.3)));  // 1.53 m
  tether.cone = to_radians(20);
  const StateCheck in_cone = alone.with_tether(tether);
  EXPECT_TRUE(in_cone.motion_valid(at(0, 1.1, -19), at(0, 1.1, 19)));
  EXPECT_FALSE(in_cone.motion_valid(at(0, 1.1, -19), at(0, 1.1, 22)));
  EXPECT_FALSE(in_cone.motion_valid(at(0, 1.1), at(0.5, 1.1)));  // 24 degrees from the vertical
}

TEST_F(Tethers, APathThatOnlyTheTetherForbidsNamesIt) {
  // the start is seen from the anchor through a slot of 0.3 m, and the vehicle fits through a door beside it
  TestBed bed = window_bed(0.3, 2.4, 0.05);
  bed.primitives.clear();
  const auto wall = [&](double y0, double y1) {
    bed.primitives.push_back({Primitive::Kind::box, "wall", Vec3(0.05, 0.5 * (y0 + y1), 1.2),
                              Vec3(0.098, y1 - y0 - 0.002, 2.398), 0});
  };
  wall(-1.5, -0.65), wall(-0.35, 0.2);
  const auto tree = make_octree(bed).value();
  const DistanceMap map = DistanceMap::create(*tree, "").value();
  Mission mission;
  mission.name = "through the door";
  mission.alpha = to_radians(30);
  mission.budget_s = 4.0;
  mission.waypoints = {{.name = "there", .pose = {Vec3(1.2, -0.87, 1.2), Quat::Identity()}, .where = {}},
                       {.name = "here", .pose = {Vec3(-0.8, 0.6, 1.2), Quat::Identity()}, .where = {}}};
  ASSERT_TRUE(omniflight::planning::plan(mission, omnimorph(), map));
  mission.tether = Tether{.anchor_W = Vec3(-1.5, 0, 0.3), .length = 4.0};
  const auto plan = omniflight::planning::plan(mission, omnimorph(), map);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::incomplete);
  EXPECT_NE(plan.error().text().find("tether_blocks_way: here"), std::string::npos) << plan.error().text();
}

TEST_F(Tethers, TwistAccumulatesAboutTheSegmentAndIsLimited) {
  Tether tether;
  tether.length = 3.0;
  std::vector<TrajectoryKnot> knots(201);
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const double t = 0.01 * static_cast<double>(k);
    knots[k].t = t;
    knots[k].reference.p_WB = Vec3(0, 0, 2);
    knots[k].reference.q_WB = from_roll_pitch_yaw(Vec3(0, 0, 4.0 * t));
    knots[k].reference.w_WB_B = Vec3(0, 0, 4.0);
  }
  EXPECT_NEAR(tether_use(tether, knots).twist, 8.0, 1e-9);  // more than a turn
  tether.twist = 7.0;
  const auto words = twist_conflict(tether, tether_use(tether, knots));
  ASSERT_TRUE(words);
  EXPECT_EQ(*words, "the way twists the tether by 458.4 deg at 2.00 s, 401.1 are allowed");
  tether.twist = 8.1;
  EXPECT_FALSE(twist_conflict(tether, tether_use(tether, knots)));
  for (auto& knot : knots) knot.reference.p_WB = Vec3(2, 0, 0);
  EXPECT_NEAR(tether_use(tether, knots).twist, 0.0, 1e-9);  // across the axis

  std::string yaml = trajectory_2_with("tether: {anchor: [0, 0, 0.58], length_m: 3, twist_deg: 60}");
  const std::string pitch = "rpy_deg: [0, 20, 0]";
  yaml.replace(yaml.find(pitch), pitch.size(), "rpy_deg: [0, 0, 80]");
  const auto mission = mission_of(yaml, "twisted");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto plan = plan_mission(*mission);
  ASSERT_FALSE(plan);
  EXPECT_NE(plan.error().text().find("tether_twisted"), std::string::npos) << plan.error().text();
}

TEST_F(Tethers, ItsWeightActsAtTheAttachment) {
  const auto v = omnimorph();
  Tether tether{.attachment_B = Vec3(0.1, 0, -0.05), .length = 2.0, .linear_mass = 0.1};
  const auto loaded = carrying(v, tether);
  const double alpha = to_radians(30);
  const Vec6 difference =
      rotor_load(loaded, alpha).required_wrench({}) - rotor_load(v, alpha).required_wrench({});
  const Vec3 force(0, 0, 0.2 * kGravity);
  EXPECT_LT((difference.head<3>() - force).norm(), 1e-9);
  EXPECT_LT((difference.tail<3>() - tether.attachment_B.cross(force)).norm(), 1e-9);
  Mission mission = *with_tether("anchor: [0, 0, 0.58], length_m: 2.2, mass_kg_per_m: 2", "heavy");
  const auto plan = plan_mission(mission);
  ASSERT_FALSE(plan);
  EXPECT_NE(plan.error().text().find("start_unhoverable"), std::string::npos) << plan.error().text();
}

TEST_F(Tethers, AFlownPathIsJudgedByLengthConeTwistAndTouch) {
  const auto check = FlownCheck::load(kConfigs / "test_beds/pyramid.bt");
  ASSERT_TRUE(check) << check.error().text();
  const Tether tether{.anchor_W = Vec3(0, 0, 0.62),
                      .length = 1.5,
                      .cone_axis_B = -Vec3::UnitZ(),
                      .cone = to_radians(40),
                      .twist = to_radians(90)};
  const auto told = [&](const std::vector<FlownPose>& path) {
    return check->tether(path, tether).violation(tether).value_or("");
  };
  const auto at = [](double t, const Vec3& p, const Vec3& rpy = Vec3::Zero()) {
    return FlownPose{t, {p, from_roll_pitch_yaw(rpy)}, 0.5};
  };
  const Vec3 up(0, 0, 1.9);
  const FlownTether fine = check->tether({at(0, up), at(1, Vec3(0.1, 0, 1.9))}, tether);
  EXPECT_FALSE(fine.violation(tether));
  EXPECT_NEAR(fine.longest, std::hypot(0.1, 1.28), 1e-9);
  EXPECT_NEAR(fine.widest, std::atan2(0.1, 1.28), 1e-9);
  EXPECT_GT(fine.nearest, 0.1);
  EXPECT_NE(told({at(0, up), at(1, Vec3(0, 0, 2.2))}).find("pulled to 1.580 m"), std::string::npos);
  EXPECT_NE(told({at(0, up, Vec3(to_radians(45), 0, 0))}).find("cone"), std::string::npos);
  std::vector<FlownPose> turning;
  for (int k = 0; k <= 10; ++k) turning.push_back(at(k, up, Vec3(0, 0, to_radians(-10.0 * k))));
  EXPECT_NE(told(turning).find("twisted by 100.0 deg"), std::string::npos) << told(turning);
  // through the frame's edge, half way up
  const Tether aside{.anchor_W = Vec3(0, 0, 1.5), .length = 5};
  const auto touched = check->tether({at(0, Vec3(0, 3, 1.5)), at(1, Vec3(3, 3, 1.5))}, aside);
  EXPECT_LE(touched.nearest, 0.0);
  EXPECT_TRUE(touched.violation(aside));
}

}  // namespace
}  // namespace omniflight::planning
