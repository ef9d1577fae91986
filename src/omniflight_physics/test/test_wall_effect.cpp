#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "wall_effect";

TEST(WallEffect, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const Vec3 e(std::cos(0.8), std::sin(0.8), 0);
    Vec6 expected = Vec6::Zero();
    for (const RotorSituation& r : s.all_rotors()) {
      const double gap = std::max(0.0, 0.5 - e.dot(s.body.p_WB + s.R_WB * r.p_BR));
      expected += at_hub(r, s.R_WB.transpose() * (0.03 * std::abs(r.thrust) * std::exp(-gap / 0.25) * e));
    }
    EXPECT_LT((wrench_of(kId, s, {0.03, 0.25, 0.8, 0.5}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(WallEffect, PullsTowardsTheWallAndFadesByTheReach) {
  Situation s = hover(1.0);
  const Vec6 here = wrench_of(kId, s, {0.03, 0.2, 0.0, 1.0});
  EXPECT_GT(here[0], 0.0);
  s.body.p_WB.x() += 0.2;
  EXPECT_NEAR(wrench_of(kId, s, {0.03, 0.2, 0.0, 1.0})[0] / here[0], std::exp(1.0), 1e-12);
  EXPECT_NEAR(here[2], 0.0, 1e-15);
}

}  // namespace
}  // namespace omniflight::physics::testing
