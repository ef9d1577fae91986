#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

TEST(GuideFriction, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const Vec3& v = s.body.v_WB_W;
    const double level = std::hypot(v.x(), v.y());
    const Vec3 f(-0.3 * std::tanh(level / 0.05) * v.x() / level,
                 -0.3 * std::tanh(level / 0.05) * v.y() / level, -0.8 * std::tanh(v.z() / 0.05));
    Vec6 expected;
    expected << s.R_WB.transpose() * f, Vec3::Zero();
    EXPECT_LT((wrench_of("guide_friction", s, {0.8, 0.3, 0.05}) - expected).norm(), 1e-12);
  }
}

TEST(GuideFriction, TakesEnergyAndNeverExceedsItsForce) {
  for (Situation s : six_states()) {
    const Vec6 w = wrench_of("guide_friction", s, {0.8, 0.3, 0.05});
    EXPECT_LT(power(s, w), 0.0);
    EXPECT_LE(w.head<3>().norm(), std::hypot(0.8, 0.3));
  }
  EXPECT_EQ(wrench_of("guide_friction", hover(1.0), {0.8, 0.3, 0.05}).norm(), 0.0);  // at rest
  EXPECT_EQ(wrench_of("guide_friction", six_states()[0], neutral_of("guide_friction")).norm(), 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
