#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "inertia_error";
const std::vector<double> kTheta{0.002, -0.001, 0.004};

TEST(InertiaError, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    // in the world: the rate of the angular momentum dJ w that nobody counted, dJ turning along
    const Mat3 dJ = s.R_WB * Vec3(0.002, -0.001, 0.004).asDiagonal() * s.R_WB.transpose();
    const Vec3 w = s.R_WB * s.body.w_WB_B, dw = s.R_WB * s.dw_WB_B;
    Vec6 expected;
    expected << Vec3::Zero(), s.R_WB.transpose() * -(dJ * dw + w.cross(dJ * w));
    EXPECT_LT((wrench_of(kId, s, kTheta) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(InertiaError, TakesTheEnergyOfTheTurningAndResistsIt) {
  for (const Situation& s : six_states()) {
    const Vec3 &w = s.body.w_WB_B, &dw = s.dw_WB_B;
    const double gained = 0.002 * w[0] * dw[0] - 0.001 * w[1] * dw[1] + 0.004 * w[2] * dw[2];
    EXPECT_NEAR(power(s, wrench_of(kId, s, kTheta)), -gained, 1e-12);
  }
  Situation s = hover(1.0);
  s.dw_WB_B = Vec3(0, 0, 3);
  EXPECT_NEAR(wrench_of(kId, s, kTheta)[5], -0.012, 1e-15);
}

}  // namespace
}  // namespace omniflight::physics::testing
