// Plans that begin in flight: they join what is flown to the third derivative, and are certified as a whole.
#include "omniflight_planning/join.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "../src/stop_ride.hpp"
#include "meshes.hpp"
#include "missions.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

/// Two rooms with a wide window, and a flight along y beside the wall.
std::string mission_yaml(const std::string& map, const std::string& waypoints) {
  return "schema: omniflight.mission/1\nname: joined\nvehicle: omnimorph\ntest_bed: " + map +
         "\nalpha_deg: 48\nclearance_m: 0.05\nbudget_ms: 100000\nstart: {position: [-1.2, -0.9, "
         "1.2]}\nwaypoints:\n" +
         waypoints;
}
void write_room(const std::string& name, double window) {
  std::ofstream(std::filesystem::path(testing::TempDir()) / name, std::ios::binary)
      << binary_stl_of(window_room(window, window));
}
struct Flown {
  Mission mission;
  Plan plan;
};
Flown flown() {
  use_shipped_configs();
  write_room("wide.stl", 1.4);
  auto mission = mission_of(
      mission_yaml("wide.stl", "  - {position: [-1.2, 0.9, 1.3], attitude: {rpy_deg: [0, 0, 40]}}\n"),
      "flown");
  EXPECT_TRUE(mission) << mission.error().text();
  auto made = plan_mission(*mission);
  EXPECT_TRUE(made) << made.error().text();
  return {std::move(*mission), std::move(*made)};
}
const Flown& old_plan() {
  static const Flown out = flown();
  return out;
}
Mission new_mission(const std::string& waypoints, const std::string& map = "wide.stl") {
  return mission_of(mission_yaml(map, waypoints), "next").value();
}
Result<Plan> replan(const Mission& mission, const FlightState& from) {
  PlanOptions options;
  options.from = from;
  return plan_mission(mission, options);
}
constexpr const char* kThroughWindow = "  - {position: [1.1, 0.2, 1.2]}\n";

TEST(Join, StateHasTheDerivativesOfTheFlownCurve) {
  const Trajectory& curve = old_plan().plan.trajectory;
  const double h = 1e-4;
  for (const double share : {0.2, 0.35, 0.5, 0.8}) {
    const double t = share * curve.duration() + 0.0037;  // between two knots
    const FlightState s = state_at(curve, t).value();
    const auto p = [&](double at) { return curve.sample(at); };
    EXPECT_LT((s.reference.v_WB_W - (p(t + h).p_WB - p(t - h).p_WB) / (2 * h)).norm(), 1e-5);
    EXPECT_LT((s.reference.a_WB_W - (p(t + h).v_WB_W - p(t - h).v_WB_W) / (2 * h)).norm(), 1e-5);
    EXPECT_LT((s.j_WB_W - (p(t + h).a_WB_W - p(t - h).a_WB_W) / (2 * h)).norm(), 1e-3);
  }
  EXPECT_FALSE(state_at(curve, -0.1));
  EXPECT_FALSE(state_at(curve, curve.duration() + 0.1));
  EXPECT_FALSE(state_at(curve, NAN));
  EXPECT_TRUE(at_rest(state_at(curve, 0.0).value()));
  EXPECT_TRUE(at_rest(state_at(curve, curve.duration()).value()));
}

TEST(Join, StopHasTheStateAtItsStartAndRestsAtItsEnd) {
  FlightState from;
  from.reference.v_WB_W = Vec3(0.4, -0.2, 0.1), from.reference.a_WB_W = Vec3(0.3, 0.5, -0.2);
  from.reference.w_WB_B = Vec3(0.2, -0.1, 0.3), from.reference.dw_WB_B = Vec3(-0.4, 0.3, 0.2);
  from.j_WB_W = Vec3(1.0, -0.7, 0.4);
  const auto curve = Trajectory::create(stop_in(1.5, from)).value();
  const double T = curve.duration();
  const auto& knots = curve.knots();
  EXPECT_EQ(knots.front().reference.v_WB_W, from.reference.v_WB_W);
  EXPECT_LT((knots.front().reference.a_WB_W - from.reference.a_WB_W).norm(), 1e-12);
  EXPECT_LT((knots.front().reference.w_WB_B - from.reference.w_WB_B).norm(), 1e-12);
  EXPECT_LT((knots.front().reference.dw_WB_B - from.reference.dw_WB_B).norm(), 1e-9);
  EXPECT_LT((jerk_between(knots[0], knots[1], 0.0) - from.j_WB_W).norm(), 1e-4);
  // rest at the end, to the jerk, and the way that the formula tells
  EXPECT_LT(jerk_between(knots[knots.size() - 2], knots.back(), kKnotPeriod).norm(), 1e-4);
  EXPECT_LT(
      (knots.back().reference.p_WB - (0.5 * T * from.reference.v_WB_W + T * T / 10.0 * from.reference.a_WB_W +
                                      T * T * T / 120.0 * from.j_WB_W))
          .norm(),
      1e-9);
  // the knots are one curve: its derivatives are those that they tell
  const double h = 1e-4;
  for (double t = 0.1; t < T - 0.1; t += 0.1037) {
    const auto a = curve.sample(t - h), b = curve.sample(t + h), now = curve.sample(t);
    EXPECT_LT((now.v_WB_W - (b.p_WB - a.p_WB) / (2 * h)).norm(), 1e-6);
    EXPECT_LT((now.w_WB_B - log_rotation(a.q_WB.conjugate() * b.q_WB) / (2 * h)).norm(), 1e-6);
    EXPECT_LT((now.dw_WB_B - (b.w_WB_B - a.w_WB_B) / (2 * h)).norm(), 1e-5);
  }
}

TEST(Join, NewPlanIsContinuousToTheThirdDerivativeAndVerified) {
  const Trajectory& old = old_plan().plan.trajectory;
  const Mission next = new_mission(kThroughWindow);
  int moving = 0;
  for (const double share : {0.25, 0.5, 0.6}) {
    const double t = share * old.duration();
    const FlightState from = state_at(old, t).value();
    moving += from.reference.v_WB_W.norm() > 0.1 && from.reference.a_WB_W.norm() > 0.01;
    const auto made = replan(next, from);
    ASSERT_TRUE(made) << made.error().text();
    const auto& knots = made->trajectory.knots();
    const Reference a = old.sample(t), &b = knots.front().reference;
    EXPECT_LT((a.p_WB - b.p_WB).norm(), 1e-12);
    EXPECT_LT((a.v_WB_W - b.v_WB_W).norm(), 1e-12);
    EXPECT_LT((a.a_WB_W - b.a_WB_W).norm(), 1e-12);
    const double h = 1e-4;  // of the flown curve, before the instant
    const Vec3 jerk = (old.sample(t).a_WB_W - old.sample(t - h).a_WB_W) / h;
    EXPECT_LT((jerk - jerk_between(knots[0], knots[1], 0.0)).norm(), 5e-3 * (1.0 + jerk.norm()));
    EXPECT_LT(a.q_WB.angularDistance(b.q_WB), 1e-9);
    EXPECT_LT((a.w_WB_B - b.w_WB_B).norm(), 1e-9);
    EXPECT_LT((a.dw_WB_B - b.dw_WB_B).norm(), 1e-9);
    EXPECT_EQ(made->certificate.verdict, "certified");
    EXPECT_LT((knots.back().reference.p_WB - next.waypoints.back().pose.p_WB).norm(), 1e-6);
    const auto dir = std::filesystem::path(testing::TempDir()) / "joined_plan";
    ASSERT_TRUE(write_plan(*made, dir));
    const auto report = verify(dir);
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_GE(report->min_clearance, 0.05 - 1e-6);
    EXPECT_NE(explain(made).find("begins in flight"), std::string::npos);
    // a flight from rest does not take it
    const auto vehicle = vehicle::load_vehicle("omnimorph").value();
    const auto match = check_match(made->certificate, next, vehicle);
    ASSERT_FALSE(match);
    EXPECT_NE(match.error().text().find("begins in flight"), std::string::npos);
  }
  EXPECT_GE(moving, 2);
}

TEST(Join, VerifyRefusesAnotherStateThanThatOfTheCertificate) {
  const FlightState from =
      state_at(old_plan().plan.trajectory, 0.4 * old_plan().plan.trajectory.duration()).value();
  auto made = replan(new_mission(kThroughWindow), from);
  ASSERT_TRUE(made) << made.error().text();
  const auto dir = std::filesystem::path(testing::TempDir()) / "joined_forged";
  for (const bool jerk : {true, false}) {
    Plan forged = *made;
    (jerk ? forged.certificate.from->j_WB_W : forged.certificate.from->reference.v_WB_W) += Vec3(0.2, 0, 0);
    ASSERT_TRUE(write_plan(forged, dir));
    const auto report = verify(dir);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().text().find(jerk ? "jerk jumps" : "does not begin with the state"),
              std::string::npos)
        << report.error().text();
  }
}

TEST(Join, KnowsAMapThatHasChanged) {
  // the window is narrower now: the new plan is certified in the new map, or there is none
  write_room("narrow.stl", 1.0);
  write_room("shut.stl", 0.1);
  const FlightState from =
      state_at(old_plan().plan.trajectory, 0.5 * old_plan().plan.trajectory.duration()).value();
  const auto made = replan(new_mission(kThroughWindow, "narrow.stl"), from);
  ASSERT_TRUE(made) << made.error().text();
  const auto dir = std::filesystem::path(testing::TempDir()) / "joined_narrow";
  ASSERT_TRUE(write_plan(*made, dir));
  EXPECT_TRUE(verify(dir)) << verify(dir).error().text();
  const Trajectory before = old_plan().plan.trajectory;
  Mission shut = new_mission(kThroughWindow, "shut.stl");
  shut.budget_s = 2.0;
  const auto none = replan(shut, from);
  ASSERT_FALSE(none);  // and the old plan is what it was
  EXPECT_FALSE(none.error().message.empty());
  EXPECT_FALSE(none.error().next_step.empty());
  EXPECT_EQ(before.duration(), old_plan().plan.trajectory.duration());
}

TEST(Join, SaysWhyThereIsNoStop) {
  const Mission next = new_mission(kThroughWindow);
  FlightState fast;
  fast.reference.p_WB = Vec3(-0.9, 0.9, 1.2);
  fast.reference.alpha = to_radians(48);
  fast.reference.v_WB_W = Vec3(0.9, 0, 0);
  auto none = replan(next, fast);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().text().find("join_over_limits: the speed comes to 0.9 m/s, 0.5"), std::string::npos)
      << none.error().text();
  fast.reference.v_WB_W = Vec3(0.45, 0, 0);  // towards the wall
  fast.reference.p_WB.x() = -0.42;
  none = replan(next, fast);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().text().find("join_blocked"), std::string::npos) << none.error().text();
  EXPECT_EQ(none.error().code, ErrorCode::incomplete);
  fast.reference.v_WB_W.x() = NAN;
  none = replan(next, fast);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::bad_input);
}

TEST(Join, IsForVehiclesThatCommandTheirAttitude) {
  Mission next = new_mission(kThroughWindow);
  PlanOptions options;
  options.vehicle = "crazyflie_brushless";
  options.from = FlightState{};
  options.from->reference.p_WB = Vec3(-1.2, 0, 1.2);
  const auto none = plan_mission(next, options);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().text().find("leans into its motion"), std::string::npos) << none.error().text();
}

}  // namespace
}  // namespace omniflight::planning
