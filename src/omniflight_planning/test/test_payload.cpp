// A rigid payload in the plan: its weight where it hangs, in plan, certificate and verification.
#include "omniflight_planning/payload.hpp"

#include <gtest/gtest.h>

#include "missions.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

struct Payloads : testing::Test {
  static void SetUpTestSuite() { setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1); }
};

Result<Mission> with_payload(const std::string& keys, const std::string& name) {
  return mission_of(trajectory_2_with("payload: {" + keys + "}"), name);
}

TEST_F(Payloads, WeightAndInertiaActAtItsPlace) {
  const auto v = omnimorph();
  const Payload payload{.mass = 0.2, .p_B = Vec3(0.1, 0, -0.05)};
  const auto loaded = carrying(v, payload);
  ASSERT_TRUE(vehicle::validate(loaded));
  const double alpha = to_radians(30);
  Reference turning;
  turning.dw_WB_B = Vec3(0, 0, 2.0);
  const auto more = [&](const Reference& r) -> Vec6 {
    return rotor_load(loaded, alpha).required_wrench(r) - rotor_load(v, alpha).required_wrench(r);
  };
  const Vec3 weight(0, 0, 0.2 * kGravity);
  EXPECT_LT((more({}).head<3>() - weight).norm(), 1e-9);
  EXPECT_LT((more({}).tail<3>() - payload.p_B.cross(weight)).norm(), 1e-9);
  // about the origin: m (x^2 + y^2) dw
  EXPECT_NEAR((more(turning) - more({})).tail<3>().z(), 0.2 * 0.01 * 2.0, 1e-9);
}

TEST_F(Payloads, PlanCarriesItTellsItAndVerifies) {
  const auto mission = with_payload("mass_kg: 0.06, position: [0.05, 0, 0]", "loaded");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto plan = plan_mission(*mission);
  ASSERT_TRUE(plan) << plan.error().text();
  auto bare = *mission;
  bare.payload.reset();
  const auto lighter = plan_mission(bare);
  ASSERT_TRUE(lighter);
  EXPECT_GT(plan->certificate.peak.rotor_load, lighter->certificate.peak.rotor_load + 0.005);
  const fs::path dir = fs::path(testing::TempDir()) / "payload_told";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto again = read_plan(dir);
  ASSERT_TRUE(again) << again.error().text();
  ASSERT_TRUE(again->certificate.payload);
  EXPECT_NEAR(again->certificate.payload->mass, 0.06, 1e-12);
  EXPECT_NEAR(again->certificate.payload->p_B.x(), 0.05, 1e-12);
  EXPECT_NE(explain(plan).find("payload of 0.060 kg"), std::string::npos);
  const auto report = verify(dir);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NEAR(report->peak.rotor_load, plan->certificate.peak.rotor_load, 1e-6);
}

TEST_F(Payloads, TooHeavyIsRefusedAndVerifyFindsAPlanThatForgotIt) {
  const auto heavy = with_payload("mass_kg: 3", "too_heavy");
  ASSERT_TRUE(heavy) << heavy.error().text();
  const auto refused = plan_mission(*heavy);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
  EXPECT_NE(refused.error().text().find("start_unhoverable"), std::string::npos) << refused.error().text();
  auto forgotten = *heavy;
  forgotten.payload.reset();
  const auto plan = plan_mission(forgotten);
  ASSERT_TRUE(plan) << plan.error().text();
  const fs::path dir = fs::path(testing::TempDir()) / "payload_forgotten";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto report = verify(dir);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().text().find("rotors' range"), std::string::npos) << report.error().text();
}

TEST_F(Payloads, BadKeysAreRefused) {
  EXPECT_FALSE(with_payload("mass_kg: -1", "negative"));
  EXPECT_FALSE(with_payload("position: [0, 0, 0]", "massless"));
}

}  // namespace
}  // namespace omniflight::planning
