#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <chrono>

#include "bench.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_planning/planner.hpp"

namespace omniflight::planning {
namespace {

const Quat kTilted = from_roll_pitch_yaw(Vec3(to_radians(60), 0, 0));

PathOptions named(std::uint64_t seed = 1, double budget = 1.0) {
  static const TestBed bed = load_test_bed(kConfigs / "test_beds/pyramid.yaml").value();
  return {.seed = seed, .budget_s = budget, .name_of = [](const Vec3& p) { return bed.nearest(p).name; }};
}

TEST(Planner, FindsAWayRoundTheFrameAndTheSameSeedGivesTheSameOne) {
  const auto check = make_check(pyramid(), 48, 0.08);
  const Pose start{Vec3(1.9, 1.9, 1.0), kTilted}, goal{Vec3(-1.9, -1.9, 1.0), kTilted};
  ASSERT_FALSE(check.motion_valid(start, goal));
  const auto first = find_path(check, start, goal, named(3)),
             second = find_path(check, start, goal, named(3));
  ASSERT_TRUE(first) << first.error().message;
  ASSERT_EQ(first->size(), second->size());
  for (std::size_t i = 0; i < first->size(); ++i) {
    EXPECT_EQ((*first)[i].p_WB, (*second)[i].p_WB);
    EXPECT_EQ((*first)[i].q_WB.coeffs(), (*second)[i].q_WB.coeffs());
  }
  for (std::size_t i = 0; i + 1 < first->size(); ++i)
    EXPECT_TRUE(check.motion_valid((*first)[i], (*first)[i + 1]));
  EXPECT_EQ(first->front().p_WB, start.p_WB);
  EXPECT_EQ(first->back().p_WB, goal.p_WB);
}

TEST(Planner, TheBestOfAFewSearchesIsShorterThanTheFirst) {
  const auto check = make_check(pyramid(), 48, 0.08);
  const Pose start{Vec3(1.9, 1.9, 1.0), kTilted}, goal{Vec3(-1.9, -1.9, 1.0), kTilted};
  double best = 0.0, first = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PathOptions as_found = named(seed);
    as_found.shortcuts = 0;
    const auto raw = find_path(check, start, goal, as_found),
               path = find_path(check, start, goal, named(seed));
    ASSERT_TRUE(raw && path);
    EXPECT_EQ(raw->front().p_WB, start.p_WB);
    EXPECT_EQ(raw->back().p_WB, goal.p_WB);
    for (std::size_t i = 0; i + 1 < raw->size(); ++i)
      EXPECT_TRUE(check.motion_valid((*raw)[i], (*raw)[i + 1])) << seed;
    first += path_length(shorten(check, *raw, seed, 300));
    best += path_length(*path);
  }
  EXPECT_LT(best, 0.97 * first);
}

TEST(Planner, WhatIsLeftOfTheBudgetMakesPathsShorterAndIsKept) {
  const auto check = make_check(pyramid(), 48, 0.08);
  const Pose start{Vec3(1.9, 1.9, 1.0), kTilted}, goal{Vec3(-1.9, -1.9, 1.0), kTilted};
  int shorter = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const auto first = find_path(check, start, goal, named(seed));
    ASSERT_TRUE(first) << first.error().message;
    const auto begin = std::chrono::steady_clock::now();
    const auto best = find_shorter_path(check, *first, named(seed, 0.2));
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_GE(took, 0.19);
    EXPECT_LE(took, 0.3);
    EXPECT_LE(path_length(best), path_length(*first));
    shorter += path_length(best) < path_length(*first);
    EXPECT_EQ(best.front().p_WB, start.p_WB);
    EXPECT_EQ(best.back().p_WB, goal.p_WB);
    for (std::size_t i = 0; i + 1 < best.size(); ++i) EXPECT_TRUE(check.motion_valid(best[i], best[i + 1]));
  }
  EXPECT_GE(shorter, 3);
  const std::vector<Pose> straight{start, start};
  EXPECT_EQ(find_shorter_path(check, straight, named(1, 10.0)).size(), 2u) << "at once";
}

TEST(Planner, EveryPlannerByNameGoesRoundAPole) {
  const DistanceMap map = pole_room(0.24);
  const auto check = make_check(map, 30, 0.05);
  const Pose start{Vec3(-1.2, 0, 1.2), Quat::Identity()}, goal{Vec3(1.2, 0, 1.2), Quat::Identity()};
  ASSERT_FALSE(check.motion_valid(start, goal));
  const auto names = planner_names();
  ASSERT_GE(names.size(), 5u);
  for (const std::string& name : names) {
    PathOptions options = named(1, 1.0);
    options.planner = name;
    const auto path = find_path(check, start, goal, options);
    ASSERT_TRUE(path) << name << ": " << path.error().message;
    ASSERT_GE(path->size(), 3u) << name;
    for (std::size_t i = 0; i + 1 < path->size(); ++i)
      EXPECT_TRUE(check.motion_valid((*path)[i], (*path)[i + 1])) << name;
    EXPECT_EQ(path->front().p_WB, start.p_WB) << name;
    EXPECT_EQ(path->back().p_WB, goal.p_WB) << name;
  }
  PlanOptions unknown;
  unknown.planner = "dijkstra";
  const auto none = plan({}, omnimorph(), map, unknown);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::bad_input);
  EXPECT_EQ(none.error().message, "there is no planner 'dijkstra'");
  EXPECT_NE(none.error().next_step.find("rrtconnect, rrt,"), std::string::npos) << none.error().next_step;
}

TEST(Planner, BadEndsAreNamedBeforeOmplSeesThem) {
  const auto check = make_check(pyramid(), 30, 0.05);
  const Pose good{Vec3(0, 0, 1.4), Quat::Identity()};
  const auto failure = [&](const Pose& a, const Pose& b) {
    const auto path = find_path(check, a, b, named());
    return path ? PathProblem{} : path.error();
  };
  const auto in_frame = failure({Vec3(0.75, 0.75, 1.5), Quat::Identity()}, good);
  EXPECT_EQ(in_frame.failure, PathFailure::start_occupied);
  EXPECT_NE(in_frame.message.find("frame beam"), std::string::npos) << in_frame.message;
  EXPECT_EQ(failure(good, {Vec3(0, 0, 0.3), Quat::Identity()}).failure, PathFailure::goal_occupied);
  EXPECT_EQ(failure(good, {Vec3(0, 0, 30), Quat::Identity()}).failure, PathFailure::outside_map);
  EXPECT_EQ(failure(good, {Vec3(NAN, 0, 1), Quat::Identity()}).failure, PathFailure::not_finite);
  EXPECT_EQ(failure({good.p_WB, Quat(NAN, 1, 0, 0)}, good).failure, PathFailure::not_finite);
  const auto steep = make_check(pyramid(), 15, 0.05);
  const auto path =
      find_path(steep, {Vec3(2.2, -2.2, 1.4), Quat::Identity()}, {Vec3(2.2, -2.2, 1.4), kTilted}, named());
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().failure, PathFailure::goal_unhoverable);
  EXPECT_NE(path.error().message.find("15.0 deg"), std::string::npos) << path.error().message;
}

TEST(Planner, ABoxedGoalIsProvenImpossible) {
  TestBed bed;
  bed.name = "box";
  bed.lower = Vec3(-2, -2, 0);
  bed.upper = Vec3(2, 2, 2);
  for (const double side :
       {-0.6, 0.6}) {  // walls round (1.2, 0, 1), with windows that are smaller than the core
    bed.primitives.push_back(
        {Primitive::Kind::box, "wall x", Vec3(1.2 + side, 0, 1), Vec3(0.05, 1.25, 2), 0});
    bed.primitives.push_back({Primitive::Kind::box, "wall y", Vec3(1.2, side, 1), Vec3(1.25, 0.05, 2), 0});
  }
  const auto closed = DistanceMap::create(*make_octree(bed).value(), "").value();
  const auto check = make_check(closed, 45, 0.05);
  const Pose start{Vec3(-1.2, 0, 1), Quat::Identity()}, goal{Vec3(1.2, 0, 1), Quat::Identity()};
  const auto begin = std::chrono::steady_clock::now();
  const auto path = find_path(check, start, goal, named(1, 5.0));
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().failure, PathFailure::proven_impossible) << path.error().message;
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
  EXPECT_FALSE(proven_disconnected(check, start.p_WB, Vec3(-1.2, 1, 1)));
  // A door half open for the ball but not for the vehicle: no proof, but the gap is named long before the
  // end.
  bed.primitives.front().b.y() = 0.5;
  const auto ajar = DistanceMap::create(*make_octree(bed).value(), "").value();
  const auto narrow = find_path(make_check(ajar, 45, 0.05), start, goal, named(1, 60.0));
  ASSERT_FALSE(narrow);
  EXPECT_EQ(narrow.error().failure, PathFailure::gap_too_narrow) << narrow.error().message;
  EXPECT_NE(narrow.error().message.find("narrows to"), std::string::npos) << narrow.error().message;
  EXPECT_NE(narrow.error().message.find("of clearance"), std::string::npos) << narrow.error().message;
}

struct Window {
  DistanceMap map;
  Pose start{Vec3(-1.2, 0.5, 1.4), from_roll_pitch_yaw(Vec3(0, 0.1, 0.7))};
  Pose goal{Vec3(1.2, -0.6, 1.0), from_roll_pitch_yaw(Vec3(0.1, 0, -0.5))};
  Window(double width, double height)
      : map(DistanceMap::create(*make_octree(window_bed(width, height, 0.025)).value(), "").value()) {}
};

/// The vehicle is 0.453 m wide: with 0.02 m of clearance 3.5 mm are left on either side.
TEST(Planner, FliesThroughASlotOfHalfAMetre) {
  const Window slot(0.5, 2.4);
  const auto check = make_check(slot.map, 30, 0.02);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto path = find_path(check, slot.start, slot.goal, named(seed, 60.0));
    ASSERT_TRUE(path) << path.error().message;
    EXPECT_EQ(path->front().p_WB, slot.start.p_WB);
    EXPECT_EQ(path->back().p_WB, slot.goal.p_WB);
    for (std::size_t i = 0; i + 1 < path->size(); ++i)
      for (int k = 0; k <= 40; ++k)
        ASSERT_GE(check.clearance(interpolate((*path)[i], (*path)[i + 1], k / 40.0)).distance, 0.02 - 1e-9);
  }
}

TEST(Planner, ATunnelThatFitsOnlyAtAttitudesThatCannotBeHeldIsToldSo) {
  TestBed bed = window_bed(0.4, 2.4, 0.025);  // 0.34 m are needed when rolled by 90 degrees
  for (Primitive& wall : bed.primitives) {    // a thin wall can be passed with a twist
    wall.a.x() = 0.3;
    wall.b.x() = 0.598;
  }
  const auto tunnel = DistanceMap::create(*make_octree(bed).value(), "").value();
  const auto path = find_path(make_check(tunnel, 5, 0.02), {Vec3(-1.2, 0.5, 1.4), Quat::Identity()},
                              {Vec3(1.2, -0.6, 1.0), Quat::Identity()}, named(1, 60.0));
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().failure, PathFailure::gap_too_narrow) << path.error().message;
  EXPECT_NE(path.error().message.find("rotors cannot hold at alpha 5.0 deg"), std::string::npos)
      << path.error().message;
}

}  // namespace
}  // namespace omniflight::planning
