#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "taut_rope";
const std::vector<double> kTheta{200, 3, 1.0, 0.2, -0.1, 0.3, 0.12};

TEST(TautRope, IsTheHandFormulaInEveryFrame) {
  int pulled = 0;
  for (const Situation& s : six_states()) {
    const Vec3 arm_W = s.R_WB * Vec3(0, 0, 0.12), to = s.body.p_WB + arm_W - Vec3(0.2, -0.1, 0.3);
    const Vec3 u = to.normalized(), v = s.body.v_WB_W + (s.R_WB * s.body.w_WB_B).cross(arm_W);
    const double pull = to.norm() > 1.0 ? std::max(0.0, 200 * (to.norm() - 1.0) + 3 * u.dot(v)) : 0.0;
    pulled += pull > 0;
    Vec6 expected;
    expected << s.R_WB.transpose() * (-pull * u), s.R_WB.transpose() * arm_W.cross(-pull * u);
    EXPECT_LT((wrench_of(kId, s, kTheta) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
  EXPECT_GT(pulled, 1);
}

TEST(TautRope, NeverPushesAndDampingTakesEnergy) {
  const std::vector<double> theta{200, 3, 1.0, 0, 0, 0, 0};
  EXPECT_EQ(wrench_of(kId, hover(0.999), theta).norm(), 0.0);
  EXPECT_NEAR(wrench_of(kId, hover(1.1), theta)[2], -20.0, 1e-12);
  Situation s = hover(1.1);
  s.v_WB_B = s.body.v_WB_W = Vec3(0, 0, -50);  // flies back faster than the spring pulls
  EXPECT_EQ(wrench_of(kId, s, theta).norm(), 0.0);
  for (const double v : {-2.0, 2.0}) {
    s.v_WB_B = s.body.v_WB_W = Vec3(0, 0, v);
    const double spring = 200 * 0.1 * -v;  // what a spring alone would do
    EXPECT_NEAR(power(s, wrench_of(kId, s, theta)) - spring, -3 * v * v, 1e-12);
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
