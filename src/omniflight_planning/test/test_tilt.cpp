// Missions whose tilt moves: what is planned is checked at every tilt, and a plan that was changed is
// refused.
#include <gtest/gtest.h>

#include <fstream>

#include "bench.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

struct Tilt : testing::Test {
  static void SetUpTestSuite() { setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1); }

  /// The shipped mission with `from` replaced.
  static Result<Plan> planned(const std::string& from = "", const std::string& to = "") {
    std::string bytes = files::read_file(kConfigs / "missions/tilt_sweep.yaml", 1 << 20).value();
    if (const auto at = bytes.find(from); at != std::string::npos)
      bytes.replace(at, from.size(), to);
    else
      ADD_FAILURE() << "the mission has no " << from;
    const fs::path file = folder() / "mission.yaml";
    std::ofstream(file) << bytes;
    const auto mission = load_mission(file.string());
    return mission ? plan_mission(*mission) : Result<Plan>(Failure(mission.error()));
  }
  /// Of this test alone: tests run beside each other.
  static fs::path folder() {
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    const fs::path out = fs::path(testing::TempDir()) / ("tilt_" + test);
    fs::create_directories(out);
    return out;
  }
};

TEST_F(Tilt, MovesAtRestNoFasterThanTheServoAndVerifies) {
  const auto plan = planned();
  ASSERT_TRUE(plan) << plan.error().text();
  const vehicle::Vehicle v = omnimorph();
  double low = 10, high = 0, fastest = 0;
  const auto& knots = plan->trajectory.knots();
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const Reference &r = knots[k].reference, &next = knots[k + 1].reference;
    low = std::min(low, r.alpha);
    high = std::max(high, r.alpha);
    const double rate = std::abs(next.alpha - r.alpha) / (knots[k + 1].t - knots[k].t);
    fastest = std::max(fastest, rate);
    if (rate > 0) {
      EXPECT_EQ((next.p_WB - r.p_WB).norm() + r.v_WB_W.norm() + r.w_WB_B.norm(), 0.0) << knots[k].t;
    }
  }
  EXPECT_NEAR(to_degrees(low), 18, 1e-9);
  EXPECT_NEAR(to_degrees(high), 42, 1e-9);
  EXPECT_GT(fastest, 0.3 * v.tilt.rate);
  EXPECT_LE(fastest, 0.5 * v.tilt.rate + 1e-9);
  EXPECT_DOUBLE_EQ(plan->certificate.alpha_lowest, low);
  EXPECT_DOUBLE_EQ(plan->certificate.alpha_highest, high);
  ASSERT_TRUE(write_plan(*plan, folder()));
  const auto read = read_plan(folder());
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_NEAR(read->certificate.alpha_highest, high, 1e-12);
  const auto report = verify(folder());
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NEAR(report->peak.rotor_load, plan->certificate.peak.rotor_load, 1e-9);
}

TEST_F(Tilt, ATiltThatCannotBeFlownIsRefused) {
  const auto refused = [](const Result<Plan>& plan, const char* reason) {
    ASSERT_FALSE(plan) << reason;
    EXPECT_NE(plan.error().text().find(reason), std::string::npos) << plan.error().text();
    EXPECT_FALSE(plan.error().next_step.empty()) << reason;
  };
  refused(planned("alpha_deg: 42", "alpha_deg: 75"), "alpha_out_of_range");
  refused(planned("alpha_deg: 42, hold_s: 2", "alpha_deg: 42, mode: via"), "via point");
  // no small torque about the vertical with parallel rotors, and none to hold a lean
  refused(planned("attitude: {rpy_deg: [0, 8, 0]}, alpha_deg: 36",
                  "attitude: {rpy_deg: [0, 8, 0]}, alpha_deg: 0"),
          "tilt_blocked");
}

TEST_F(Tilt, AChangedPlanIsRefused) {
  const auto plan = planned();
  ASSERT_TRUE(plan) << plan.error().text();
  const auto refused = [&](const auto& change, const char* reason) {
    Plan bent = *plan;
    auto knots = bent.trajectory.knots();
    change(knots);
    bent.trajectory = Trajectory::create(knots).value();
    ASSERT_TRUE(write_plan(bent, folder()));
    const auto report = verify(folder());
    ASSERT_FALSE(report) << reason;
    EXPECT_NE(report.error().text().find(reason), std::string::npos) << report.error().text();
  };
  const auto tilted = [&](double add) {
    return [add](std::vector<TrajectoryKnot>& knots) {
      for (TrajectoryKnot& k : knots)
        if (k.reference.alpha > to_radians(41.9999)) k.reference.alpha += add;
    };
  };
  refused(tilted(to_radians(25)), "not reached in its turn");
  refused([](auto& knots) { knots.front().reference.alpha += 0.1; }, "certificate's alpha");
  refused(  // while it climbs
      [](auto& knots) {
        for (std::size_t k = 1; k + 1 < knots.size(); ++k)
          if (knots[k].reference.v_WB_W.norm() > 0.1) knots[k].reference.alpha += 1e-3;
      },
      "moves while the vehicle does");
  refused(  // at once instead of in a second and a half
      [](auto& knots) {
        for (TrajectoryKnot& k : knots)
          if (k.reference.alpha > to_radians(30.001) && k.t < 5) k.reference.alpha = to_radians(42);
      },
      "the servo does");
}

}  // namespace
}  // namespace omniflight::planning
