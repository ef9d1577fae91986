// The thesis's chapter 5.3 in one scenario: what the weights of cases A and B do when the rotors give less
// thrust than the allocator believes, the more so the lower the tilt (35 % at 0 deg, rising linearly to 70 %
// at 60 deg).
#include <gtest/gtest.h>

#include "omniflight_allocation/closed_loop.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

double nominal(double) { return 1.0; }
double lossy(double alpha) { return 0.35 + 0.35 * alpha / to_radians(60.0); }

AllocatorConfig case_b_dynamic() {
  AllocatorConfig config = AllocatorConfig::case_b();
  config.dynamic_weights.enabled = true;  // threshold 0.05 m, 1.01, 0.9, [1e-9, 1e-5]
  return config;
}

// Position gains 25 and 300 (damping 0.72; the thesis gives only the second, by its sag). Attitude gains are
// not published: the verdicts must hold for all three sets. With other position damping the margin of case A
// vanishes: it is lost at 34.6 with attitude gains below 300, and at 12 with all of them.
class CaseAB : public ::testing::TestWithParam<LoopGains> {
 protected:
  LoopResult flight(const AllocatorConfig& config, double (*scale)(double)) {
    return fly(omnimorph(1.315, 6.25), config, 1.6, scale, GetParam());
  }
};

TEST_P(CaseAB, BothFollowWhenTheModelIsRight) {
  for (const AllocatorConfig& config : {AllocatorConfig::case_a(), AllocatorConfig::case_b()}) {
    const LoopResult r = flight(config, nominal);
    EXPECT_FALSE(r.failed);
    EXPECT_LT(r.worst_error, 1e-3);
    EXPECT_LT(to_degrees(r.worst_angle), 0.2);
  }
}

TEST_P(CaseAB, CaseASurvivesTheMismatch) {
  const LoopResult r = flight(AllocatorConfig::case_a(), lossy);
  EXPECT_FALSE(r.failed);
  EXPECT_NEAR(r.worst_error, 0.062, 0.002);
  // 2.57, 1.09 and 0.55 deg with exact optima: the error falls with the stiffness of the attitude loop
  EXPECT_LT(to_degrees(r.worst_angle), 170.0 / GetParam().kr2);
}

TEST_P(CaseAB, CaseBFailsUnderTheMismatch) {
  const LoopResult r = flight(AllocatorConfig::case_b(), lossy);
  EXPECT_TRUE(r.failed);
  EXPECT_NEAR(r.end, 7.75, 0.15);  // while it pitches
}

TEST_P(CaseAB, DynamicWeightsSaveCaseB) {
  const LoopResult r = flight(case_b_dynamic(), lossy);
  EXPECT_FALSE(r.failed);
  EXPECT_NEAR(r.worst_error, 0.062, 0.002);
  EXPECT_LT(to_degrees(r.worst_angle), 2.5);
}

TEST_P(CaseAB, DynamicWeightsNeedALowFloor) {
  AllocatorConfig config = case_b_dynamic();
  config.dynamic_weights.floor = 1e-7;
  EXPECT_TRUE(flight(config, lossy).failed);
}

// Level, before it moves: a loop that gets a share s of its thrust sags by g (1/s - 1) / kp2.
TEST_P(CaseAB, SagHasItsClosedForm) {
  AllocatorConfig config;
  config.tilt_mode = TiltMode::fixed;
  const LoopResult r = fly(
      omnimorph(), config, 1.6, [](double) { return 0.65; }, GetParam(), 2.0);
  EXPECT_FALSE(r.failed);
  EXPECT_NEAR(r.last_error, kGravity * (1 / 0.65 - 1) / GetParam().kp2, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(AttitudeGains, CaseAB,
                         ::testing::Values(LoopGains{25, 300, 15, 60}, LoopGains{25, 300, 24.5, 150},
                                           LoopGains{25, 300, 34.6, 300}),
                         [](const auto& gains) {
                           return "kr" + std::to_string(static_cast<int>(gains.param.kr2));
                         });

}  // namespace
}  // namespace omniflight::allocation
