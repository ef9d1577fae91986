#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "bench.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"
#include "quadrotor.hpp"

#include <octomap/OcTree.h>

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

Mission move(const Vec3& by, double yaw_deg = 0) {
  Mission m;
  m.name = "move";
  m.alpha = 0.0;
  const Pose start{Vec3(0, 0, 1.2), Quat::Identity()};
  const Pose end{start.p_WB + by, from_roll_pitch_yaw(Vec3(0, 0, to_radians(yaw_deg)))};
  m.waypoints = {{.name = "start", .pose = start, .where = {}}, {.name = "end", .pose = end, .where = {}}};
  return m;
}

TEST(Actuation, AQuadrotorLeansIntoAMoveSideways) {
  for (const Vec3& by : {Vec3(0.5, 0, 0), Vec3(0, -0.2, 0.3), Vec3(0.001, 0, 0.5)}) {
    const auto plan = omniflight::planning::plan(move(by, 30), quadrotor(), pyramid());
    ASSERT_TRUE(plan) << plan.error().text();
    const Certificate& c = plan->certificate;
    EXPECT_LT(c.duration, 5.0);  // s
    EXPECT_TRUE(c.leans);
    EXPECT_LT((c.thrust_axis_B - Vec3::UnitZ()).norm(), 1e-9);
    // the certificate tells the lean of the knots, and it is that of their accelerations
    double most = 0;
    for (const TrajectoryKnot& k : plan->trajectory.knots()) {
      const Vec3 thrust = k.reference.a_WB_W + kGravity * Vec3::UnitZ();
      EXPECT_LT((k.reference.q_WB * Vec3::UnitZ() - thrust.normalized()).norm(), 1e-9);
      most = std::max(most, std::acos(std::min(1.0, thrust.normalized().z())));
    }
    EXPECT_NEAR(c.peak.lean, most, 1e-6);
    EXPECT_GT(most, by.head<2>().norm() > 0.1 ? to_radians(1) : 0.0);
  }
}

TEST(Actuation, AQuadrotorClimbsAndYaws) {
  for (const auto& mission : {move(Vec3(0, 0, 0.5)), move(Vec3::Zero(), 90), move(Vec3(0, 0, 0.3), -60)}) {
    const auto plan = omniflight::planning::plan(mission, quadrotor(), pyramid());
    ASSERT_TRUE(plan) << plan.error().text();
    EXPECT_LT(plan->certificate.duration, 10.0);  // s
  }
}

TEST(Actuation, AnAttitudeThatCannotBeHeldIsRefusedWithTheNearestThatCan) {
  Mission m = move(Vec3(0.3, 0, 0));
  m.waypoints[1].pose.q_WB = from_roll_pitch_yaw(Vec3(0, to_radians(20), 0)) * exp_rotation(Vec3(0, 0, 0));
  const auto plan = omniflight::planning::plan(m, quadrotor(), pyramid());
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::bad_input);
  for (const char* word : {"goal_unhoverable", "pitch 20.0", "underactuated",
                           "(0.30, 0.00, 1.20) m is reachable", "{rpy_deg: [0.0, 0.0, 0.0]}"})
    EXPECT_NE(plan.error().text().find(word), std::string::npos) << plan.error().text();
}

/// A wall so near that a hard lean would touch it: the plan leans less.
TEST(Actuation, WhereThereIsNoRoomToLeanTheVehicleIsSlower) {
  const auto slit = [](double half_height) {
    octomap::OcTree tree(0.02);
    for (double x = -0.49; x < 2; x += 0.02)
      for (double y = -0.49; y < 0.5; y += 0.02)
        for (double z = 0.61; z < 1.4; z += 0.02)
          tree.updateNode(
              octomap::point3d(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)),
              std::abs(z - 1.0) > half_height);
    const fs::path file = fs::path(testing::TempDir()) / "slit.bt";
    std::ofstream(file, std::ios::binary) << octree_bytes(tree).value();
    return DistanceMap::load(file).value();
  };
  Mission m = move(Vec3(1.5, 0, 0));
  for (Waypoint& w : m.waypoints) w.pose.p_WB.z() = 1.0;
  m.limits.speed = 3, m.limits.acceleration = 6, m.limits.rate = 6, m.limits.angular_acceleration = 60;
  m.clearance = 0.01;
  const DistanceMap low = slit(0.12), high = slit(0.35);
  const auto narrow = omniflight::planning::plan(m, quadrotor(), low);
  ASSERT_TRUE(narrow) << narrow.error().text();
  const auto wide = omniflight::planning::plan(m, quadrotor(), high);
  ASSERT_TRUE(wide) << wide.error().text();
  EXPECT_GT(narrow->certificate.duration, 1.3 * wide->certificate.duration);
  EXPECT_LT(narrow->certificate.peak.lean, 0.6 * wide->certificate.peak.lean);
  EXPECT_GT(wide->certificate.peak.lean, to_radians(15));
}

TEST(Actuation, AMissionThatWouldNeedTwoControlLawsIsRefused) {
  Mission m = move(Vec3(0.1, 0, 0));
  m.waypoints[1].alpha = to_radians(30);
  m.waypoints.push_back({.name = "tilted", .pose = {Vec3(0.2, 0, 1.2), Quat::Identity()}, .where = {}});
  const auto plan = omniflight::planning::plan(m, omnimorph(), pyramid());
  ASSERT_FALSE(plan);
  EXPECT_NE(plan.error().text().find("mixed_actuation"), std::string::npos) << plan.error().text();
  m.waypoints.pop_back();  // a tilt that moves at rest is no motion of the vehicle
  const auto leaning = omniflight::planning::plan(m, omnimorph(), pyramid());
  ASSERT_TRUE(leaning) << leaning.error().text();
  EXPECT_TRUE(leaning->certificate.leans);
}

/// A via point is passed with its heading and the lean of the motion there; the plan is read and verified as
/// written.
TEST(Actuation, ALeaningPlanIsVerifiedFromItsFiles) {
  setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1);
  const fs::path dir = fs::path(testing::TempDir()) / "leaning";
  fs::create_directories(dir);
  std::ofstream(dir / "via.yaml") << "schema: omniflight.mission/1\nname: via\nvehicle: crazyflie_brushless\n"
                                     "test_bed: pyramid\nalpha_deg: 0\nclearance_m: 0.05\n"
                                     "limits: {speed_mps: 1, acceleration_mps2: 2, lean_deg: 12}\n"
                                     "start: {position: [0, 0, 1.2]}\nwaypoints:\n"
                                     "  - {by: [0.3, 0, 0], mode: via, attitude: {rpy_deg: [0, 0, 30]}}\n"
                                     "  - {by: [0.3, 0.3, 0.1], hold_s: 1}\n";
  const auto mission = load_mission((dir / "via.yaml").string());
  ASSERT_TRUE(mission) << mission.error().text();
  EXPECT_NEAR(mission->limits.lean, to_radians(12), 1e-12);
  auto plan = plan_mission(*mission);
  ASSERT_TRUE(plan) << plan.error().text();
  ASSERT_TRUE(write_plan(*plan, dir / "plan"));
  const auto report = verify(dir / "plan");
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NEAR(report->peak.lean, plan->certificate.peak.lean, 1e-9);
  EXPECT_GT(report->peak.lean, to_radians(2));
  // one that stays level on the same way is not what this vehicle flies
  auto knots = plan->trajectory.knots();
  for (TrajectoryKnot& k : knots) {
    k.reference.q_WB = Quat::Identity();
    k.reference.w_WB_B = k.reference.dw_WB_B = Vec3::Zero();
  }
  plan->trajectory = Trajectory::create(knots).value();
  ASSERT_TRUE(write_plan(*plan, dir / "level"));
  EXPECT_FALSE(verify(dir / "level"));
}

TEST(Actuation, ACertificateThatIsBentIsRefusedByField) {
  setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1);
  const fs::path dir = fs::path(testing::TempDir()) / "bent";
  auto plan = omniflight::planning::plan(move(Vec3(0.3, 0, 0)), quadrotor(), pyramid());
  ASSERT_TRUE(plan) << plan.error().text();
  ASSERT_TRUE(write_plan(*plan, dir));
  std::ifstream in(dir / "certificate.json");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto bent = [&](const std::string& from, const std::string& to, const char* word) {
    std::string other = text;
    const auto at = other.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    std::ofstream(dir / "certificate.json") << other.replace(at, from.size(), to);
    const auto read = read_plan(dir);
    ASSERT_FALSE(read) << to;
    EXPECT_EQ(read.error().code, ErrorCode::bad_input);
    EXPECT_NE(read.error().text().find(word), std::string::npos) << read.error().text();
  };
  bent("\"from_acceleration\": true", "\"from_acceleration\": 1", "from_acceleration");
  bent("\"thrust_axis\"", "\"thrust\"", "thrust_axis");
  bent("\"lean_deg\"", "\"lean\"", "lean_deg");
  const auto axis = text.find("\"thrust_axis\": ["), end = text.find(']', axis);
  bent(text.substr(axis, end + 1 - axis), "\"thrust_axis\": [0, 0, 0.5]", "unit length");
  bent(text.substr(axis, end + 1 - axis), "\"thrust_axis\": [0, 0]", "thrust_axis");
}

TEST(Actuation, AVehicleWithoutTorqueAboutAnAxisHasNoPlanThatMovesAside) {
  auto trirotor = quadrotor();
  trirotor.rotors.pop_back();
  const auto plan = omniflight::planning::plan(move(Vec3(0.3, 0, 0)), trirotor, pyramid());
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::bad_input);
  EXPECT_FALSE(plan.error().next_step.empty());
  auto heavy = quadrotor();
  heavy.mass = 3;
  const auto falls = omniflight::planning::plan(move(Vec3(0.3, 0, 0)), heavy, pyramid());
  ASSERT_FALSE(falls);
  EXPECT_NE(falls.error().text().find("hover"), std::string::npos) << falls.error().text();
}

/// A mission in an unknown region: the map's box is known but for a block beside the start.
TEST(Verify, UnknownSpaceIsAnObstacleAsInPlanning) {
  setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1);
  const fs::path dir = fs::path(testing::TempDir()) / "unknown_space";
  fs::create_directories(dir);
  const auto write_map = [&](bool hole) {
    octomap::OcTree tree(0.1);
    for (double x = -2.95; x < 3; x += 0.1)
      for (double y = -1.95; y < 2; y += 0.1)
        for (double z = 0.05; z < 3; z += 0.1) {
          if (hole && x > 0.9 && x < 1.5 && std::abs(y) < 0.8 && z > 0.8 && z < 2.2) continue;
          tree.updateNode(
              octomap::point3d(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)),
              x < -2.9);
        }
    std::ofstream(dir / "room.bt", std::ios::binary) << octree_bytes(tree).value();
  };
  std::ofstream(dir / "aside.yaml")
      << "schema: omniflight.mission/1\nname: aside\nvehicle: omnimorph\n"
         "test_bed: room.bt\nalpha_deg: 30\nclearance_m: 0.05\n"
         "start: {position: [0, 0, 1.5]}\nwaypoints:\n  - {position: [1.2, 0, 1.5]}\n";
  const auto planned = [&] {
    const auto mission = load_mission((dir / "aside.yaml").string());
    return mission ? plan_mission(*mission) : Result<Plan>(Failure(mission.error()));
  };
  write_map(false);
  auto plan = planned();
  ASSERT_TRUE(plan) << plan.error().text();
  ASSERT_TRUE(write_plan(*plan, dir / "plan"));
  ASSERT_TRUE(verify(dir / "plan"));
  write_map(true);
  EXPECT_FALSE(planned()) << "planning flies into unknown space";
  // the same curve with the hash of the new map: verify itself must see where it goes
  plan->certificate.map_sha256 = read_octree(dir / "room.bt").value().sha256;
  ASSERT_TRUE(write_plan(*plan, dir / "plan"));
  const auto report = verify(dir / "plan");
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().text().find("comes within"), std::string::npos) << report.error().text();
}

TEST(Match, APlanIsOfOneMissionVehicleMassAndMap) {
  setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1);
  const auto one = load_mission("trajectory_1"), two = load_mission("trajectory_2");
  ASSERT_TRUE(one && two);
  PlanOptions options;
  options.set = {"mass=1.4"};
  const auto plan = plan_mission(*one, options);
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_DOUBLE_EQ(plan->certificate.vehicle_mass, 1.4);
  const fs::path dir = fs::path(testing::TempDir()) / "match";
  ASSERT_TRUE(write_plan(*plan, dir));
  EXPECT_TRUE(verify(dir)) << "the overrides are in the certificate";
  const auto c = read_plan(dir).value().certificate;
  ASSERT_EQ(c.vehicle_set, options.set);
  const auto load = [](const char* spec, const std::vector<std::string>& set) {
    return vehicle::load_vehicle(spec, set).value();
  };
  EXPECT_TRUE(check_match(c, *one, load("omnimorph", {"mass=1.4"})));
  const auto refused = [&](const Mission& mission, const vehicle::Vehicle& v, const char* word) {
    const auto ok = check_match(c, mission, v);
    ASSERT_FALSE(ok) << word;
    EXPECT_NE(ok.error().text().find(word), std::string::npos) << ok.error().text();
  };
  refused(*two, load("omnimorph", {"mass=1.4"}), "'trajectory_1', not of 'trajectory_2'");
  refused(*one, load("omnimorph", {}), "1.315 kg");
  refused(*one, load("omnimorph@table_4_1", {}), "kg");
  refused(*one, load("omnimorph", {"mass=1.4", "rotors.max_thrust=5"}), "differs");
  Mission elsewhere = *one;
  elsewhere.test_bed = dir / "trajectory.json";
  refused(elsewhere, load("omnimorph", {"mass=1.4"}), "map");
}

}  // namespace
}  // namespace omniflight::planning
