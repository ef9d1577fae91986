// Searches side by side: the same path whichever thread is quicker.
#include <gtest/gtest.h>

#include "bench.hpp"
#include "omniflight_planning/planner.hpp"

namespace omniflight::planning {
namespace {

struct Room {
  DistanceMap map;
  StateCheck check;
  Pose start{Vec3(-1.2, 0.5, 1.4), from_roll_pitch_yaw(Vec3(0, 0.1, 0.7))};
  Pose goal{Vec3(1.2, -0.6, 1.0), from_roll_pitch_yaw(Vec3(0.1, 0, -0.5))};
  explicit Room(double window)
      : map(DistanceMap::create(*make_octree(window_bed(window, window, 0.05)).value(), "").value()),
        check(make_check(map, 30, 0.02)) {}
  PathResult<std::vector<Pose>> plan(std::uint64_t seed, int threads, double budget_s = 100.0) const {
    PathOptions options;
    options.seed = seed;
    options.threads = threads;
    options.budget_s = budget_s;
    options.deadline = Deadline(budget_s);
    return find_path(check, start, goal, options);
  }
};

void expect_same(const PathResult<std::vector<Pose>>& a, const PathResult<std::vector<Pose>>& b) {
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->size(), b->size());
  for (std::size_t i = 0; i < a->size(); ++i) {
    EXPECT_EQ((*a)[i].p_WB, (*b)[i].p_WB);
    EXPECT_EQ((*a)[i].q_WB.coeffs(), (*b)[i].q_WB.coeffs());
  }
}

TEST(Portfolio, RepeatsForASeedAndANumberOfThreads) {
  const Room room(1.0);
  for (const int threads : {1, 2, 3})
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const auto first = room.plan(seed, threads);
      ASSERT_TRUE(first) << first.error().message;
      for (std::size_t i = 0; i + 1 < first->size(); ++i)
        EXPECT_TRUE(room.check.motion_valid((*first)[i], (*first)[i + 1]));
      for (int again = 0; again < 3; ++again) expect_same(room.plan(seed, threads), first);
    }
}

TEST(Portfolio, GoesThroughGapsAsOneThreadDoes) {
  // the first block finds nothing here, so that gaps decide, which no other search overtakes
  const Room room(0.6);
  const auto one = room.plan(1, 1), two = room.plan(1, 2);
  ASSERT_TRUE(one) << one.error().message;
  ASSERT_TRUE(two) << two.error().message;
  EXPECT_EQ(one->front().p_WB, two->front().p_WB);
  EXPECT_EQ(one->back().p_WB, two->back().p_WB);
  expect_same(room.plan(1, 2), two);
}

TEST(Portfolio, EndsWithTheDeadlineInEveryThread) {
  const Room room(0.1);  // nothing fits
  const Deadline watch(1000.0);
  const auto none = room.plan(1, 4, 0.5);
  EXPECT_FALSE(none);
  EXPECT_LT(1000.0 - watch.left(), 20.0);  // s; the machine may be busy
}

TEST(Portfolio, StopsWhenTold) {
  const Room room(0.1);
  PathOptions options;
  options.threads = 3;
  options.deadline = Deadline(100.0, [] { return true; });
  EXPECT_FALSE(find_path(room.check, room.start, room.goal, options));
}

}  // namespace
}  // namespace omniflight::planning
