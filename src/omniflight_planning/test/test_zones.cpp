// Zones of a mission: keep-out solids, a box to stay in, and what unknown space counts as.
#include "omniflight_planning/zones.hpp"

#include <gtest/gtest.h>

#include "../src/octree_boxes.hpp"
#include "missions.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"
#include "repetitions.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

struct Zoned : testing::Test {
  static void SetUpTestSuite() { use_shipped_configs(); }
};

Zones sphere_and_plate() {
  Zones zones;
  zones.keep_out.push_back({.kind = Primitive::Kind::capsule,
                            .name = "person",
                            .a = Vec3(1.5, 0.2, 0.3),
                            .b = Vec3(1.5, 0.2, 1.6),
                            .radius = 0.3});
  zones.keep_out.push_back(
      {.kind = Primitive::Kind::box, .name = "plate", .a = Vec3(-1.2, 0.4, 1.1), .b = Vec3(0.5, 0.5, 0.004)});
  return zones;
}

/// The middles of the voxels that the zones close, one after the other.
std::vector<Vec3> closed_voxels(const Zones& zones, const DistanceMap& map) {
  const double half = 0.5 * map.resolution();
  std::vector<Vec3> out;
  const auto [nx, ny, nz] = map.size();
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const Vec3 c = map.voxel_center(x, y, z);
        bool closed = false;
        for (const Primitive& solid : zones.keep_out)
          closed |= solid.distance(c) <= std::sqrt(3.0) * half + 1e-6 && solid.touches_cube(c, half);
        if (zones.keep_in)
          closed |= ((c - (*zones.keep_in)[0]).minCoeff() < half - 1e-9) ||
                    (((*zones.keep_in)[1] - c).minCoeff() < half - 1e-9);
        if (closed) out.push_back(c);
      }
  return out;
}

double distance_to_cubes(const std::vector<Vec3>& middles, double half, const Vec3& p) {
  double best = HUGE_VAL;
  for (const Vec3& c : middles)
    best = std::min(best, ((p - c).cwiseAbs().array() - half).max(0.0).matrix().squaredNorm());
  return std::sqrt(best);
}

TEST_F(Zoned, TheDistancesAreThoseToTheClosedVoxelsToo) {
  for (const bool kept_in : {false, true}) {
    Zones zones = sphere_and_plate();
    if (kept_in) zones.keep_in = {Vec3(-2.03, -2.01, 0.11), Vec3(2.2, 2.15, 2.2)};
    DistanceMap map = pyramid();
    ASSERT_TRUE(map.close(zones));
    const std::vector<Vec3> closed = closed_voxels(zones, map);
    Random random(1);
    for (int i = 0; i < 10 * times(); ++i) {
      std::array<int, 3> at{};
      for (std::size_t k = 0; k < 3; ++k) at[k] = static_cast<int>(random.uniform() * map.size()[k]);
      const double before = pyramid().voxel_distance(at[0], at[1], at[2]);
      const double zone =
          distance_to_cubes(closed, 0.5 * map.resolution(), map.voxel_center(at[0], at[1], at[2]));
      ASSERT_NEAR(map.voxel_distance(at[0], at[1], at[2]), std::min({before, zone, map.max_distance()}),
                  1e-5);
    }
  }
}

TEST_F(Zoned, TheVerifiersBoxesAreNoFartherThanTheirVoxels) {
  const Zones zones = sphere_and_plate();
  DistanceMap map = pyramid();
  ASSERT_TRUE(map.close(zones));
  OctreeBoxes boxes(*read_octree(kConfigs / "test_beds/pyramid.bt").value().tree, zones);
  const StateCheck check = make_check(map, 45, 0.0);
  Random random(2);
  int near = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 p(random.uniform(-2, 2), random.uniform(-1, 1), random.uniform(0.7, 1.7));
    const Pose pose{p, Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized()};
    const double exact = boxes.clearance(pose, check.spheres());
    const double told = check.clearance(pose).distance;
    if (told > 0.0) {
      ASSERT_LE(std::min(told, kBoxHorizon), exact + 1e-3);
    }
    near += exact < 0.3 && told > 0.0;
  }
  EXPECT_GT(near, 20);
}

/// From one side of the pyramid to the other, outside of it, with further keys.
Result<Mission> past(const std::string& keys, const std::string& name) {
  return mission_of("schema: omniflight.mission/1\nname: " + name +
                        "\nvehicle: omnimorph\ntest_bed: pyramid\nalpha_deg: 48\nclearance_m: 0.05\n" + keys +
                        "\nstart: {position: [1.9, 1.5, 1.2]}\nwaypoints: [{position: [1.9, -1.5, 1.2]}]\n",
                    name);
}

constexpr const char* kPost =
    "keep_out: [{name: post, kind: cylinder, base: [1.9, 0, 0], height: 2.5, radius: 0.15}]";

TEST_F(Zoned, APlanGoesRoundAKeepOutAndIsVerifiedWithIt) {
  const auto mission = past(kPost, "round_a_post");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto made = plan_mission(*mission);
  ASSERT_TRUE(made) << made.error().text();
  for (const auto& knot : made->trajectory.knots())
    ASSERT_GT((knot.reference.p_WB - Vec3(1.9, 0, 1.2)).head<2>().norm(), 0.15 + 0.05);
  const fs::path dir = fs::path(testing::TempDir()) / "round_a_post";
  ASSERT_TRUE(write_plan(*made, dir));
  const auto report = verify(dir);
  EXPECT_TRUE(report) << report.error().text();
  // a plan that has not heard of it goes through, and is refused
  PlanOptions options;
  options.map_file = mission->test_bed.string();
  auto straight = plan(*mission, omnimorph(), pyramid(), options);
  ASSERT_TRUE(straight) << straight.error().text();
  ASSERT_TRUE(write_plan(*straight, dir));
  const auto refused = verify(dir);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::incomplete);
  EXPECT_NE(refused.error().text().find("comes within"), std::string::npos) << refused.error().text();
}

TEST_F(Zoned, AStartInAKeepOutNamesIt) {
  const auto mission = past(
      "keep_out: [{name: the operator, kind: box, center: [1.9, 1.5, 1], size: [0.5, 0.5, 2]}]", "operator");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto made = plan_mission(*mission);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::bad_input);
  EXPECT_NE(made.error().text().find("'the operator'"), std::string::npos) << made.error().text();
}

TEST_F(Zoned, ABoxToStayInIsNotLeft) {
  const std::string box = "keep_in: {min: [1.2, -2.2, 0.6], max: [2.4, 2.2, 2.0]}";
  const auto mission = past(box, "in_a_box");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto made = plan_mission(*mission);
  ASSERT_TRUE(made) << made.error().text();
  for (const auto& knot : made->trajectory.knots()) {
    const Vec3 p = knot.reference.p_WB;
    ASSERT_TRUE(p.x() > 1.2 && p.x() < 2.4 && p.z() > 0.6 && p.z() < 2.0) << p.transpose();
  }
  const fs::path dir = fs::path(testing::TempDir()) / "in_a_box";
  ASSERT_TRUE(write_plan(*made, dir));
  EXPECT_TRUE(verify(dir));
  // both ways are shut
  const auto shut = past(box + "\n" + kPost, "shut");
  ASSERT_TRUE(shut) << shut.error().text();
  PlanOptions brief;
  brief.budget_s = 2.0;
  const auto none = plan_mission(*shut, brief);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().code, ErrorCode::bad_input) << none.error().text();
}

TEST_F(Zoned, UnknownSpaceIsAKeyOfTheMission) {
  const fs::path dir = fs::path(testing::TempDir()) / "unknown_key";
  fs::create_directories(dir);
  octomap::OcTree tree(0.1);  // a room of 4 m; a block in its middle was never seen
  for (double x = -1.95; x < 2; x += 0.1)
    for (double y = -1.95; y < 2; y += 0.1)
      for (double z = 0.05; z < 3; z += 0.1)
        if (std::max({std::abs(x), std::abs(y), std::abs(z - 1.5)}) > 0.5)
          tree.updateNode(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), z < 0.1, true);
  tree.updateInnerOccupancy();
  ASSERT_TRUE(tree.writeBinary((dir / "room.bt").string()));
  const auto through = [&](const std::string& keys) {
    const std::string yaml =
        "schema: omniflight.mission/1\nname: seen\nvehicle: omnimorph\ntest_bed: room.bt\nalpha_deg: 48\n" +
        keys + "\nstart: {position: [0, 0, 1.5]}\nwaypoints: [{position: [0.2, 0, 1.5]}]\n";
    std::ofstream(dir / "seen.yaml") << yaml;
    return load_mission((dir / "seen.yaml").string());
  };
  const auto strict = through(""), loose = through("unknown: free");
  ASSERT_TRUE(strict && loose);
  const auto refused = plan_mission(*strict);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("start_occupied"), std::string::npos) << refused.error().text();
  const auto made = plan_mission(*loose);
  ASSERT_TRUE(made) << made.error().text();
  ASSERT_TRUE(write_plan(*made, dir / "plan"));
  const auto report = verify(dir / "plan");
  EXPECT_TRUE(report) << report.error().text();
}

TEST_F(Zoned, MistakesNameFieldAndLine) {
  const auto why = [](const std::string& keys) {
    const auto mission = past(keys, "bad_zones");
    return mission ? std::string("accepted") : mission.error().text();
  };
  EXPECT_NE(why("unknown: maybe").find("unknown"), std::string::npos);
  EXPECT_NE(why("keep_in: {min: [1, 0, 0], max: [0, 1, 1]}").find("no inside"), std::string::npos);
  EXPECT_NE(why("keep_in: {min: [1.2, -1, 0.6], max: [2.4, 2.2, 2.0]}").find("does not hold 'waypoint 1'"),
            std::string::npos);
  EXPECT_NE(why("keep_out: [{name: ball, kind: sphere}]").find("keep_out[0].kind"), std::string::npos);
  EXPECT_NE(why("keep_out: [{name: b, kind: box, center: [0, 0, .nan], size: [1, 1, 1]}]").find("center"),
            std::string::npos);
}

}  // namespace
}  // namespace omniflight::planning
