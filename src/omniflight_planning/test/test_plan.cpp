#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <iostream>

#include "missions.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

Result<Plan> planned(const std::string& name) {
  const auto mission = load_mission((kConfigs / "missions" / (name + ".yaml")).string());
  return mission ? plan_mission(*mission) : Result<Plan>(Failure(mission.error()));
}

/// Least distance of the true rotor rims to any occupied voxel along a trajectory, by brute force.
double closest_rim(const Trajectory& trajectory, const vehicle::Vehicle& v) {
  static const auto boxes = [] {
    const auto file = read_octree(kConfigs / "test_beds/pyramid.bt").value();
    std::vector<std::pair<Vec3, double>> out;
    for (auto leaf = file.tree->begin_leafs(); leaf != file.tree->end_leafs(); ++leaf)
      if (file.tree->isNodeOccupied(*leaf))
        out.emplace_back(Vec3(leaf.getX(), leaf.getY(), leaf.getZ()), 0.5 * leaf.getSize());
    return out;
  }();
  const auto distance = [](const Vec3& p, const std::pair<Vec3, double>& box) {
    return ((p - box.first).cwiseAbs().array() - box.second).max(0.0).matrix().norm();
  };
  double best = 1.0;
  for (double t = 0.0; t < trajectory.duration(); t += 0.097) {
    const Reference r = trajectory.sample(t);
    std::vector<Vec3> rim;
    for (int i = 0; i < v.rotor_count(); ++i) {
      const auto& rotor = v.rotors[static_cast<std::size_t>(i)];
      const Vec3 n = v.rotor_axis(i, r.alpha), x = n.unitOrthogonal(), y = n.cross(x);
      for (int k = 0; k < 24; ++k)
        rim.push_back(r.p_WB + r.q_WB * (rotor.p_BR + rotor.radius * (std::cos(k * kPi / 12) * x +
                                                                      std::sin(k * kPi / 12) * y)));
    }
    for (const auto& box : boxes) {
      if (distance(r.p_WB, box) > 0.32 + best) continue;
      for (const Vec3& p : rim) best = std::min(best, distance(p, box));
    }
  }
  return best;
}

struct Missions : testing::TestWithParam<const char*> {
  static void SetUpTestSuite() { use_shipped_configs(); }
};
struct Plans : testing::Test {
  static void SetUpTestSuite() { use_shipped_configs(); }
};
INSTANTIATE_TEST_SUITE_P(Shipped, Missions, testing::Values("trajectory_1", "trajectory_2", "around_frame"),
                         [](const auto& shipped) { return std::string(shipped.param); });

TEST_P(Missions, PlanVerifyAndKeepWhatTheyPromise) {
  const std::clock_t begin = std::clock();  // of CPU: a busy machine stretches the wall time up to budget_ms
  const auto plan = planned(GetParam());
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  ASSERT_TRUE(plan) << plan.error().text();
  std::cout << explain(plan) << "planned in " << seconds << " s of CPU\n";
  EXPECT_LT(seconds, 2.0);

  const auto& knots = plan->trajectory.knots();
  const auto v = omnimorph();
  const Certificate& c = plan->certificate;
  const auto rotors = rotor_load(v, c.alpha);
  const auto a = v.allocation_matrix(c.alpha);
  const Eigen::MatrixXd pinv = a.completeOrthogonalDecomposition().pseudoInverse();
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    EXPECT_NEAR(knots[k + 1].t - knots[k].t, 0.01, 1e-9);
    // C2: the values reached from the left are those of the knot, and half-way the motion is what its
    // neighbours say.
    const double t1 = knots[k + 1].t;
    const Reference left = plan->trajectory.sample(t1 - 1e-7), right = plan->trajectory.sample(t1);
    if (k + 2 == knots.size()) continue;
    EXPECT_LT((left.a_WB_W - right.a_WB_W).norm(), 1e-4);
    EXPECT_LT((left.dw_WB_B - right.dw_WB_B).norm(), 1e-4);
    EXPECT_LT((left.v_WB_W - right.v_WB_W).norm(), 1e-6);
    const Reference& r = knots[k].reference;
    EXPECT_LE(rotors.motion_load(r), 1.0 - c.limits.rotor_headroom + 1e-9);
    EXPECT_LE(r.v_WB_W.norm(), c.limits.speed + 1e-9);
    EXPECT_LE(r.w_WB_B.norm(), c.limits.rate + 1e-9);
  }
  // The derivatives stored on the knots are those of the curve.
  for (double t = 0.5; t + 0.5 < plan->trajectory.duration(); t += 0.173) {
    const Reference r0 = plan->trajectory.sample(t - 1e-4), r = plan->trajectory.sample(t),
                    r1 = plan->trajectory.sample(t + 1e-4);
    EXPECT_LT(((r1.p_WB - r0.p_WB) / 2e-4 - r.v_WB_W).norm(), 1e-5);
    EXPECT_LT((log_rotation(r0.q_WB.conjugate() * r1.q_WB) / 2e-4 - r.w_WB_B).norm(), 1e-5);
  }
  // A controller that allocates by the pseudo-inverse stays within the limits, too.
  for (const auto& knot : knots)
    EXPECT_LT((pinv * rotors.required_wrench(knot.reference)).cwiseAbs().maxCoeff(), 6.25);

  EXPECT_GE(closest_rim(plan->trajectory, v), c.clearance_asked);

  const fs::path dir = fs::path(testing::TempDir()) / (std::string("plan_") + GetParam());
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_GE(report->min_clearance, c.clearance_asked);
  EXPECT_NEAR(report->duration, c.duration, 1e-9);
  const auto again = read_plan(dir);
  ASSERT_TRUE(again) << again.error().text();
  ASSERT_EQ(again->trajectory.knots().size(), knots.size());
  EXPECT_EQ(again->trajectory.knots()[77].reference.p_WB, knots[77].reference.p_WB);

  const auto second = planned(GetParam());
  ASSERT_TRUE(second);
  ASSERT_EQ(second->trajectory.knots().size(), knots.size());
  for (std::size_t k = 0; k < knots.size(); k += 50)
    EXPECT_EQ(second->trajectory.knots()[k].reference.p_WB, knots[k].reference.p_WB);
}

TEST_F(Plans, ThesisTrajectoriesHaveTheirLengthAndHeight) {
  const auto one = planned("trajectory_1"), two = planned("trajectory_2");
  ASSERT_TRUE(one && two);
  for (const Plan* plan : {&*one, &*two}) {
    EXPECT_GE(plan->trajectory.duration(), 30.0);
    EXPECT_LE(plan->trajectory.duration(), 45.0);
  }
  double low = 10, high = 0, tilt = 0;
  for (const auto& k : two->trajectory.knots()) {
    low = std::min(low, k.reference.p_WB.z());
    high = std::max(high, k.reference.p_WB.z());
    tilt = std::max(tilt, k.reference.q_WB.angularDistance(Quat::Identity()));
  }
  EXPECT_GE(high - low, 0.7 - 1e-9);
  EXPECT_NEAR(to_degrees(tilt), 20.0, 1e-6);
}

TEST_F(Plans, TamperedPlansAreRefused) {
  const auto plan = planned("trajectory_1");
  ASSERT_TRUE(plan);
  const fs::path dir = fs::path(testing::TempDir()) / "tampered";
  ASSERT_TRUE(write_plan(*plan, dir));
  const std::string good = files::read_file(dir / "trajectory.json", 1 << 26).value();
  const auto refused = [&](const std::string& content, const std::string& reason) {
    std::ofstream(dir / "trajectory.json") << content;
    const auto read = read_plan(dir);
    ASSERT_FALSE(read) << reason;
    EXPECT_NE(read.error().text().find(reason), std::string::npos) << read.error().text();
  };
  refused(good.substr(0, good.size() / 2), "hashes differ");
  refused("", "hashes differ");
  // The hash renewed, the content absurd: the curve now leaves the map.
  Plan bent = *plan;
  auto knots = bent.trajectory.knots();
  for (std::size_t k = 500; k < knots.size(); ++k) knots[k].reference.p_WB.x() += 0.4;
  bent.trajectory = Trajectory::create(knots).value();
  ASSERT_TRUE(write_plan(bent, dir));
  const auto report = verify(dir);
  ASSERT_FALSE(report);
  // A wild interior that knots alone do not show: one knot far away with no velocity.
  knots = plan->trajectory.knots();
  knots.erase(knots.begin() + 100, knots.begin() + 300);
  knots[100].reference.p_WB.z() = 1.3;
  bent.trajectory = Trajectory::create(knots).value();
  ASSERT_TRUE(write_plan(bent, dir));
  EXPECT_TRUE(verify(dir)) << "a hold written with fewer knots is the same flight";
}

TEST_F(Plans, HostilePlanFilesAreRefusedWithAReason) {
  const auto plan = planned("trajectory_1");
  ASSERT_TRUE(plan);
  const fs::path dir = fs::path(testing::TempDir()) / "hostile";
  ASSERT_TRUE(write_plan(*plan, dir));
  const std::string certificate = files::read_file(dir / "certificate.json", 1 << 20).value();
  const std::string hash = files::sha256_file(dir / "trajectory.json").value();
  const std::string knot =
      R"({"t":0.0,"p":[0,0,1],"q":[1,0,0,0],"v":[0,0,0],"w":[0,0,0],"a":[0,0,0],"dw":[0,0,0],"alpha":0.5})";
  const auto file = [&](const std::string& knots) {
    return R"({"schema":"omniflight.trajectory/1","knots":)" + knots + "}";
  };
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = knot;
    return file("[" + text.replace(text.find(from), from.size(), to) + "]");
  };
  const struct {
    std::string content, reason;
  } cases[] = {
      {std::string(1000000, '['), "no JSON object"},
      {"[]", "no JSON object"},
      {R"({"schema":"other/1","knots":[]})", "schema"},
      {file("[]"), "knots"},
      {file("7"), "knots"},
      {file("[3]"), "knots[0].t"},
      {changed("[0,0,1]", "[0,0]"), "knots[0].p"},
      {changed("[0,0,1]", "[0,0,\"1\"]"), "knots[0].p"},
      {changed("[0,0,1]", "[0,0,1e300]"), "knots[0].p"},
      {changed("[0,0,1]", "[0,0,1e999]"), "no JSON object"},
      {changed("[0,0,1]", "[0,0,NaN]"), "no JSON object"},
      {changed("[1,0,0,0]", "[0,0,0,0]"), "quaternion"},
      {changed("\"t\":0.0", "\"t\":-1"), "knots[0].t"},
      {changed("\"t\":0.0", "\"t\":1"), "first knot"},
      {file("[" + knot + "," + knot + "]"), "does not increase"},
      {changed("0.5", "50"), "alpha"},
  };
  for (const auto& c : cases) {
    std::ofstream(dir / "trajectory.json") << c.content;
    std::string matching = certificate;
    matching.replace(matching.find(hash), hash.size(), files::sha256_hex(c.content));
    std::ofstream(dir / "certificate.json") << matching;
    const auto read = read_plan(dir);
    ASSERT_FALSE(read) << c.reason;
    EXPECT_NE(read.error().text().find(c.reason), std::string::npos)
        << c.reason << ": " << read.error().text();
  }
}

TEST_F(Plans, AViaPointIsFlownThroughAndAlphaIsFoundBySearch) {
  const auto mission = load_mission((kConfigs / "missions/around_frame.yaml").string());
  ASSERT_TRUE(mission);
  const auto plan = plan_mission(*mission);
  ASSERT_TRUE(plan);
  EXPECT_TRUE(plan->certificate.alpha_searched);
  EXPECT_GT(to_degrees(plan->certificate.alpha), 41.0);  // below, a roll of 60 degrees cannot be held
  double nearest = 1.0, speed = 0.0, outside = 0.0, roll = 0.0;
  for (const auto& knot : plan->trajectory.knots()) {
    const Reference& r = knot.reference;
    roll = std::max(roll, roll_pitch_yaw(r.q_WB).x());
    outside = std::max(outside, r.p_WB.head<2>().cwiseAbs().maxCoeff() - 1.5 * (1.0 - r.p_WB.z() / 3.0));
    if (const double d = (r.p_WB - Vec3(0, -2.0, 1.1)).norm(); d < nearest) {
      nearest = d;
      speed = r.v_WB_W.norm();
    }
  }
  EXPECT_LT(nearest, 0.005);
  EXPECT_GT(speed, 0.1);
  EXPECT_GT(outside, 0.5);  // m beyond the planes of the pyramid
  EXPECT_GE(to_degrees(roll), 60.0 - 1e-6);
}

TEST_F(Plans, RandomFlightsKeepTheirClearanceFromEveryVoxel) {
  const auto v = vehicle::load_vehicle("omnimorph@table_4_1").value();  // the heaviest variant
  const auto pyramid_check = make_check(pyramid(), 50, 0.07);
  Random random(21);
  const auto pose = [&] {
    while (true) {
      const Pose p{Vec3(random.uniform(-2.8, 2.8), random.uniform(-2.8, 2.0), random.uniform(0.5, 3.2)),
                   exp_rotation(Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)))};
      if (pyramid_check.valid(p)) return p;
    }
  };
  int planned_flights = 0;
  for (int i = 0; i < 8; ++i) {
    Mission mission;
    mission.name = "random";
    mission.alpha = to_radians(50);
    mission.clearance = 0.06;
    mission.limits.speed = 1.0;
    mission.budget_s = 1.0;
    mission.waypoints = {{.name = "start", .pose = pose(), .where = {}},
                         {.name = "end", .pose = pose(), .where = {}}};
    const auto plan = omniflight::planning::plan(mission, v, pyramid());
    if (!plan) continue;  // an attitude between two good ones may need too much thrust
    ++planned_flights;
    EXPECT_GE(closest_rim(plan->trajectory, v), 0.06) << i;
    EXPECT_LE(plan->certificate.peak.rotor_load, 0.9 + 1e-9);
  }
  EXPECT_GE(planned_flights, 6);
}

TEST_F(Plans, ASlotThatLeavesMillimetresIsFlownWithItsClearance) {
  const auto tree = make_octree(window_bed(0.5, 2.4, 0.025)).value();  // the vehicle is 0.453 m wide
  const auto map = DistanceMap::create(*tree, "").value();
  Mission mission;
  mission.name = "slot";
  mission.alpha = to_radians(30);
  mission.clearance = 0.02;
  mission.budget_s = 60.0;
  mission.waypoints = {{.name = "start", .pose = {Vec3(-1.2, 0.4, 1.3), Quat::Identity()}, .where = {}},
                       {.name = "end", .pose = {Vec3(1.2, -0.4, 1.1), Quat::Identity()}, .where = {}}};
  const auto plan = omniflight::planning::plan(mission, omnimorph(), map);
  ASSERT_TRUE(plan) << plan.error().text();
  const auto check = make_check(map, 30, 0.02);
  for (double t = 0.0; t <= plan->certificate.duration; t += 0.05) {
    const Reference r = plan->trajectory.sample(t);
    ASSERT_GE(check.clearance({r.p_WB, r.q_WB}).distance, 0.02 - 1e-9) << t;
  }
  EXPECT_GE(plan->certificate.min_clearance, 0.02);
}

struct Refusal {
  const char *what, *from, *to, *reason;
  ErrorCode code;
};

TEST_F(Plans, AnytimeUsesTheBudgetForShorterPathsAndKeepsIt) {
  std::string yaml = files::read_file(kConfigs / "missions/around_frame.yaml", 1 << 20).value();
  const auto first = plan_mission(mission_of(yaml, "first").value());
  yaml.insert(yaml.find("start: {position"), "search: anytime\n");
  const auto mission = mission_of(yaml, "anytime");
  ASSERT_TRUE(mission) << mission.error().text();
  PlanOptions options;
  options.budget_s = 1.0;
  const auto begin = std::chrono::steady_clock::now();
  const auto best = plan_mission(*mission, options);
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_TRUE(best) << best.error().text();
  EXPECT_GE(took, 0.3) << "legs that are not straight use their share of what is left";
  EXPECT_LE(took, 1.1);
  EXPECT_LE(best->certificate.duration, 1.02 * first->certificate.duration);
  EXPECT_FALSE(mission_of(yaml.replace(yaml.find("anytime"), 7, "forever"), "forever"));
}

TEST_F(Plans, BadMissionsNameFileFieldAndNextStep) {
  const std::string good = files::read_file(kConfigs / "missions/trajectory_2.yaml", 1 << 20).value();
  const Refusal cases[] = {
      {"unknown key", "clearance_m:", "clearence_m:", "clearance_m", ErrorCode::bad_input},
      {"alpha beyond the vehicle", "alpha_deg: 30", "alpha_deg: 75", "alpha_out_of_range",
       ErrorCode::bad_input},
      {"start inside the frame", "[0, 0, 0.9]", "[0.7, 0.7, 1.5]", "frame beam", ErrorCode::bad_input},
      {"start outside the map", "[0, 0, 0.9]", "[0, 0, 90]", "outside_map", ErrorCode::bad_input},
      {"start not a number", "[0, 0, 0.9]", "[0, .nan, 0.9]", "start.position", ErrorCode::bad_input},
      {"too steep for the tilt", "[0, 20, 0]", "[0, 85, 0]", "goal_unhoverable", ErrorCode::bad_input},
      {"quaternion", "{rpy_deg: [0, 20, 0]}", "{quaternion: [1, 1, 0, 0]}", "norm", ErrorCode::bad_input},
      {"no test bed", "test_bed: pyramid", "test_bed: nowhere", "nowhere", ErrorCode::bad_input},
      {"no vehicle", "vehicle: omnimorph", "vehicle: nothing", "nothing", ErrorCode::bad_input},
      {"schema", "mission/1", "mission/7", "mission/1", ErrorCode::bad_input},
      {"budget 0", "budget_ms: 10000", "budget_ms: 0", "budget_ms", ErrorCode::bad_input},
      {"waypoint outside the map", "[0.3, 0, 0]", "[30, 0, 0]", "outside_map", ErrorCode::bad_input},
      {"waypoint in an obstacle", "[0.3, 0, 0]", "[0, 0, 0.6]", "goal_occupied", ErrorCode::bad_input},
      {"map missing", "test_bed: pyramid", "test_bed: missing.bt", "missing.bt", ErrorCode::bad_input},
      {"map cut", "test_bed: pyramid", "test_bed: cut.bt", "cut.bt", ErrorCode::bad_input},
      {"map empty", "test_bed: pyramid", "test_bed: empty.bt", "empty.bt", ErrorCode::bad_input},
  };
  const std::string map = files::read_file(kConfigs / "test_beds/pyramid.bt", 1 << 24).value();
  std::ofstream(fs::path(testing::TempDir()) / "cut.bt") << map.substr(0, map.size() / 2);
  std::ofstream(fs::path(testing::TempDir()) / "empty.bt");
  for (const auto& c : cases) {
    std::string bytes = good;
    const auto at = bytes.find(c.from);
    ASSERT_NE(at, std::string::npos) << c.what;
    bytes.replace(at, std::string(c.from).size(), c.to);
    const fs::path path = fs::path(testing::TempDir()) / "bad_mission.yaml";
    std::ofstream(path) << bytes;
    const auto mission = load_mission(path.string());
    const auto plan = mission ? plan_mission(*mission) : Result<Plan>(Failure(mission.error()));
    ASSERT_FALSE(plan) << c.what;
    EXPECT_EQ(plan.error().code, c.code) << c.what;
    EXPECT_NE(plan.error().text().find(c.reason), std::string::npos) << c.what << ": " << plan.error().text();
    EXPECT_FALSE(plan.error().where.empty() && plan.error().next_step.empty()) << c.what;
  }
}

}  // namespace
}  // namespace omniflight::planning
