#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "cable_torsion";

double twist(const Mat3& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }
double bend(const Mat3& R) { return std::acos(std::clamp(R(2, 2), -1.0, 1.0)); }

TEST(CableTorsion, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const Vec3 up = s.R_WB.transpose() * Vec3::UnitZ();
    const Vec3 joint = (Vec3::UnitZ() + up) / (1 + up.z());  // along the bisector of both ends
    const double turn = 0.03 * (twist(s.R_WB) - 0.2) + 0.004 * joint.dot(s.body.w_WB_B);
    Vec6 expected;
    expected << Vec3::Zero(), -turn * joint + 0.05 * bend(s.R_WB) * Vec3::UnitZ().cross(up).normalized();
    EXPECT_LT((wrench_of(kId, s, {0.03, 0.05, 0.004, 0.2}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(CableTorsion, SpringsGiveBackWhatTheyTookAndTheDamperTakes) {
  for (const Situation& s : six_states()) {
    const auto stored = [&](double dt) {
      const Mat3 R = later(s, dt).R_WB;
      return 0.5 * 0.03 * std::pow(twist(R) - 0.2, 2) + 0.5 * 0.05 * std::pow(bend(R), 2);
    };
    const double dt = 1e-5;
    EXPECT_NEAR(power(s, wrench_of(kId, s, {0.03, 0.05, 0, 0.2})), -(stored(dt) - stored(-dt)) / (2 * dt),
                1e-7);
    EXPECT_LT(power(s, wrench_of(kId, s, {0, 0, 0.004, 0})), 0.0);
  }
}

TEST(CableTorsion, ActsAgainstYawAndTiltAndIsFiniteUpsideDown) {
  const auto turned = [](const Vec3& by) {
    RigidState b;
    b.q_WB = exp_rotation(by);
    return wrench_of(kId, situation(cube(), b, 0, std::vector<double>(8, 700.0)), {0.03, 0.05, 0.004, 0});
  };
  EXPECT_NEAR(turned({0, 0, 0.5})[5], -0.03 * 0.5, 1e-12);
  EXPECT_NEAR(turned({0.3, 0, 0})[3], -0.05 * 0.3, 1e-12);
  EXPECT_TRUE(turned({kPi, 0, 0}).allFinite());
}

}  // namespace
}  // namespace omniflight::physics::testing
