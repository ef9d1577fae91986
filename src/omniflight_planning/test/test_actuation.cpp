#include <gtest/gtest.h>

#include <fstream>

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

TEST(Actuation, AQuadrotorThatStaysLevelCannotMoveSidewaysAtAnySpeed) {
  for (const Vec3& by : {Vec3(0.3, 0, 0), Vec3(0, -0.2, 0.3), Vec3(0.001, 0, 0.5)}) {
    const auto plan = omniflight::planning::plan(move(by), quadrotor(), pyramid());
    ASSERT_FALSE(plan) << by.transpose() << ": " << plan->certificate.duration << " s";
    EXPECT_EQ(plan.error().code, ErrorCode::bad_input);
    EXPECT_NE(plan.error().text().find("underactuated"), std::string::npos) << plan.error().text();
    EXPECT_NE(plan.error().text().find("rank 4 of 6"), std::string::npos) << plan.error().text();
  }
}

TEST(Actuation, AQuadrotorClimbsAndYaws) {
  for (const auto& mission : {move(Vec3(0, 0, 0.5)), move(Vec3::Zero(), 90), move(Vec3(0, 0, 0.3), -60)}) {
    const auto plan = omniflight::planning::plan(mission, quadrotor(), pyramid());
    ASSERT_TRUE(plan) << plan.error().text();
    EXPECT_LT(plan->certificate.duration, 10.0);  // s
  }
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
