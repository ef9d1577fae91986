#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "payload_mass";

TEST(PayloadMass, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const Vec3 a = s.R_WB * s.a_WB_B;
    Vec6 expected;
    expected << s.R_WB.transpose() * (-0.28 * (a + Vec3(0, 0, kGravity))), Vec3::Zero();
    EXPECT_LT((wrench_of(kId, s, {0.28}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(PayloadMass, TakesTheEnergyThatTheMassGains) {
  for (const Situation& s : six_states()) {
    const Vec3 &v = s.body.v_WB_W, a = s.R_WB * s.a_WB_B;
    // kinetic and potential energy [J] along the motion: of second degree in the time, so that the mean slope
    // between -1 s and 1 s is the slope now
    const auto energy = [&](double t) {
      return 0.28 * (0.5 * (v + a * t).squaredNorm() + kGravity * (v.z() * t + 0.5 * a.z() * t * t));
    };
    EXPECT_NEAR(power(s, wrench_of(kId, s, {0.28})), -(energy(1) - energy(-1)) / 2, 1e-12);
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
