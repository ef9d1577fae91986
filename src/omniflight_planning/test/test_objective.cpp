// What a plan prefers: time, energy or clearance.
#include <gtest/gtest.h>

#include "missions.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

struct Objectives : testing::Test {
  static void SetUpTestSuite() { use_shipped_configs(); }
};

Result<Plan> planned(const std::string& keys, const std::string& waypoints) {
  const auto mission = mission_of(
      "schema: omniflight.mission/1\nname: prefers\nvehicle: omnimorph\ntest_bed: pyramid\nalpha_deg: 48\n"
      "clearance_m: 0.05\n" +
          keys + "\n" + waypoints + "\n",
      "prefers");
  if (!mission) return Failure(mission.error());
  PlanOptions options;
  options.figures = true;
  return plan_mission(*mission, options);
}

constexpr const char* kAside = "start: {position: [0, 0, 1.3]}\nwaypoints: [{by: [0.3, 0, 0.1]}]";

TEST_F(Objectives, EnergyTakesNoMoreThanEitherTiming) {
  for (const char* limits : {"limits: {speed_mps: 3, acceleration_mps2: 8}", "limits: {speed_mps: 0.3}"}) {
    const std::string keys = limits;
    const auto energy = planned(keys + "\nobjective: energy", kAside);
    ASSERT_TRUE(energy) << energy.error().text();
    ASSERT_TRUE(energy->certificate.energy);
    for (const char* timing : {"minimum_jerk", "shortest"}) {
      const auto other = planned(keys + "\ntiming: " + timing, kAside);
      ASSERT_TRUE(other) << other.error().text();
      EXPECT_LE(*energy->certificate.energy, *other->certificate.energy * (1 + 1e-9)) << timing;
    }
  }
}

TEST_F(Objectives, EnergyOfHoveringIsThatOfItsThrusts) {
  const auto still = planned("", "start: {position: [0, 0, 1.3]}\nwaypoints: [{hold_s: 10}]");
  ASSERT_TRUE(still) << still.error().text();
  const auto v = omnimorph();
  double watts = 0.0;
  for (int i = 0; i < 8; ++i) {
    const auto& rotor = v.rotors[static_cast<std::size_t>(i)];
    const double speed = rotor.speed(still->figures.front().thrusts[i]);
    watts += rotor.drag_ratio * rotor.thrust_coefficient * std::pow(std::abs(speed), 3);
  }
  EXPECT_NEAR(*still->certificate.energy, watts * still->certificate.duration, 1e-6 * watts);
  const std::filesystem::path dir = std::filesystem::path(testing::TempDir()) / "energy";
  ASSERT_TRUE(write_plan(*still, dir));
  EXPECT_NEAR(*read_plan(dir).value().certificate.energy, *still->certificate.energy, 1e-9);
}

TEST_F(Objectives, ClearanceKeepsMoreRoomWhereThereIsSome) {
  // past the outside of a beam: the straight way has little more than the clearance
  const char* past = "start: {position: [2.6, 2.6, 1.2]}\nwaypoints: [{position: [2.6, -2.6, 1.2]}]";
  const char* post = "keep_out: [{name: post, kind: cylinder, base: [2.3, 0, 0], height: 3, radius: 0.1}]\n";
  const auto quick = planned(std::string(post), past),
             roomy = planned(std::string(post) + "objective: clearance", past);
  ASSERT_TRUE(quick) << quick.error().text();
  ASSERT_TRUE(roomy) << roomy.error().text();
  EXPECT_GE(roomy->certificate.min_clearance, quick->certificate.min_clearance);
  EXPECT_GE(roomy->certificate.min_clearance, 0.2);
}

TEST_F(Objectives, AnUnknownOneIsRefusedWithTheKnown) {
  const auto wrong = planned("objective: beauty", kAside);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("clearance"), std::string::npos) << wrong.error().text();
}

}  // namespace
}  // namespace omniflight::planning
