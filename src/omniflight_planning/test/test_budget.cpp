// The whole of a plan ends within its budget and 100 ms, whatever the budget: a result or the reason why
// there is none.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>

#include "../src/pace.hpp"
#include "bench.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

constexpr double kGrace = 0.1;  // s beyond the budget

constexpr int kMissions = 7;

/// Of each mission; 200 in all at each budget in the long tests, see CMakeLists.txt.
int repetitions() {
  const char* told = std::getenv("OMNIFLIGHT_REPETITIONS");
  return told ? std::max(1, (std::atoi(told) + kMissions - 1) / kMissions) : 5;
}

/// s; the longest ones in the long tests alone.
std::vector<double> budgets() {
  std::vector<double> out{1e-3, 5e-3, 20e-3, 60e-3, 200e-3};
  if (std::getenv("OMNIFLIGHT_REPETITIONS")) out.insert(out.end(), {600e-3, 2.0, 6.0});
  return out;
}

struct Budget : testing::TestWithParam<double> {
  static void SetUpTestSuite() { setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1); }
};

std::vector<Mission> missions() {
  std::vector<Mission> out;
  for (const char* name : {"trajectory_1", "around_frame", "tilt_sweep", "figure_eight"})
    out.push_back(load_mission(name).value());
  Mission narrow =
      load_mission("around_frame").value();  // the ball passes the gap, the vehicle does not: no proof
  narrow.name = "no way through";
  narrow.clearance = 0.47;
  narrow.waypoints = {{.name = "start", .pose = {Vec3(0, 0, 1.3), Quat::Identity()}, .where = {}},
                      {.name = "end", .pose = {Vec3(0, -2.5, 1.3), Quat::Identity()}, .where = {}}};
  narrow.alpha = to_radians(30);
  out.push_back(narrow);
  Mission holds = load_mission("trajectory_1").value();  // 2.5 hours: timing and certificate take longest
  holds.name = "long holds";
  for (int k = 0; k < 14; ++k) holds.waypoints[1 + k % 6].hold_s = 600;
  out.push_back(holds);
  Mission shortest = load_mission("around_frame").value();
  shortest.name = "shortest";
  shortest.timing = Timing::shortest;
  shortest.anytime = true;
  out.push_back(shortest);
  return out;
}

TEST_P(Budget, IsKeptByTheWholePlan) {
  const double budget = GetParam();
  ASSERT_EQ(missions().size(), kMissions);
  double worst = 0;
  int late = 0, planned = 0, runs = 0;
  for (const Mission& mission : missions())
    for (int k = 0; k < repetitions(); ++k) {
      PlanOptions options;
      options.budget_s = budget;
      options.seed = static_cast<std::uint64_t>(k + 1);
      // A busy machine may take the processor away behind the deadline, a loop that does not look at it is
      // late every time.
      double over = 0;
      Result<Plan> plan = Failure(Error{});
      for (int attempt = 0; attempt < 3 && (attempt == 0 || over > kGrace); ++attempt) {
        const auto begin = std::chrono::steady_clock::now();
        plan = plan_mission(mission, options);
        over = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() - budget;
      }
      ++runs;
      planned += plan.has_value();
      late += over > kGrace;
      worst = std::max(worst, over);
      EXPECT_LE(over, kGrace) << mission.name << " seed " << k + 1
                              << (plan ? "" : ": " + plan.error().text());
      if (!plan) {
        EXPECT_EQ(plan.error().code, ErrorCode::incomplete) << plan.error().text();
        EXPECT_FALSE(plan.error().next_step.empty()) << plan.error().text();
      }
    }
  std::cout << "budget " << 1e3 * budget << " ms: " << runs - late << " of " << runs << " within "
            << 1e3 * kGrace << " ms of it, worst " << 1e3 * worst << " ms beyond; " << planned
            << " planned\n";
}

TEST(Pace, AThreadThatIsNotServedIsSlow) {
  const Pace pace;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_GT(pace.slowdown(), 10.0);
  EXPECT_LE(pace.slowdown(), 100.0);
}

INSTANTIATE_TEST_SUITE_P(Plans, Budget, testing::ValuesIn(budgets()), [](const auto& budget) {
  return "In" + std::to_string(std::lround(1e3 * budget.param)) + "Milliseconds";
});

}  // namespace
}  // namespace omniflight::planning
