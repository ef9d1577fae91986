// Another goal or another map while a plan is flown: one trajectory, the old one up to the join.
#include "omniflight_planning/replan.hpp"

#include <gtest/gtest.h>

#include "missions.hpp"
#include "omniflight_planning/octree_file.hpp"

namespace omniflight::planning {
namespace {

struct Replans : testing::Test {
  static void SetUpTestSuite() { use_shipped_configs(); }
};

Result<Mission> going(const std::string& name, const std::string& to, const std::string& bed = "pyramid") {
  return mission_of(
      "schema: omniflight.mission/1\nname: " + name + "\nvehicle: omnimorph\ntest_bed: " + bed +
          "\nalpha_deg: 45\nclearance_m: 0.05\nbudget_ms: 30000\nstart: {position: [0, 0, 1.0]}\n"
          "waypoints:\n  - {position: " +
          to + "}\n",
      name);
}

TEST_F(Replans, FollowsTheOldTrajectoryToTheJoinAndEndsAtTheNewGoal) {
  const auto first = plan_mission(going("up", "[0, 0, 1.8]").value());
  ASSERT_TRUE(first) << first.error().text();
  const auto mission = going("aside", "[0.3, 0.2, 1.2]");
  ASSERT_TRUE(mission) << mission.error().text();
  for (const double share : {0.4, 0.503, 1.2}) {  // between knots and after the end, too
    const double join = share * first->trajectory.duration();
    const auto next = replan(*mission, first->trajectory, join);
    ASSERT_TRUE(next) << next.error().text();
    const Trajectory& whole = next->trajectory;
    EXPECT_NEAR(whole.duration(), join + next->plan.trajectory.duration(), 1e-9);
    EXPECT_NEAR((whole.knots().back().reference.p_WB - Vec3(0.3, 0.2, 1.2)).norm(), 0.0, 1e-6);
    EXPECT_EQ(next->plan.certificate.verdict, "certified");
    for (double t = 0.0; t < join; t += 0.0037) {
      const Reference a = first->trajectory.sample(t), b = whole.sample(t);
      ASSERT_NEAR((a.p_WB - b.p_WB).norm(), 0.0, 1e-9) << t;
      ASSERT_NEAR((a.v_WB_W - b.v_WB_W).norm(), 0.0, 1e-7) << t;
      ASSERT_NEAR((a.a_WB_W - b.a_WB_W).norm(), 0.0, 1e-5) << t;
    }
    const Reference before = whole.sample(join - 1e-6), after = whole.sample(join + 1e-6);
    EXPECT_LT((before.v_WB_W - after.v_WB_W).norm(), 1e-4);
    EXPECT_LT((before.a_WB_W - after.a_WB_W).norm(), 1e-3);
  }
}

TEST_F(Replans, AnotherMapSendsItRoundWhatHasAppeared) {
  const auto first = plan_mission(going("across", "[0.6, 0, 1.0]").value());
  ASSERT_TRUE(first) << first.error().text();
  TestBed bed = load_test_bed(kConfigs / "test_beds/pyramid.yaml").value();
  bed.primitives.push_back({Primitive::Kind::cylinder, "post", Vec3(0.62, 0, 0.6), Vec3(0.62, 0, 1.4), 0.05});
  const auto bytes = octree_bytes(**make_octree(bed));
  ASSERT_TRUE(bytes);
  const auto file = written("with_a_post.bt", *bytes);
  // the goal of before is in the post now, and so the old trajectory is kept
  const auto there = replan(going("there", "[0.6, 0, 1.0]", file.string()).value(), first->trajectory, 0.5);
  ASSERT_FALSE(there);
  EXPECT_NE(there.error().text().find("goal_occupied"), std::string::npos) << there.error().text();
  const auto above = replan(going("above", "[0.3, 0, 1.5]", file.string()).value(), first->trajectory, 0.5);
  ASSERT_TRUE(above) << above.error().text();
  EXPECT_EQ(above->plan.certificate.map_file, file.string());
}

TEST_F(Replans, ATimeWithoutATrajectoryIsRefused) {
  const auto mission = going("nowhere", "[0, 0, 1.2]");
  EXPECT_FALSE(replan(*mission, Trajectory{}, 0.0));
  EXPECT_FALSE(replan(*mission, plan_mission(*mission)->trajectory, -1.0));
}

}  // namespace
}  // namespace omniflight::planning
