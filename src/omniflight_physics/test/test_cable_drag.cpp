#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "cable_drag";

TEST(CableDrag, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const double length = std::clamp(s.body.p_WB.z() - 0.4, 0.0, 0.9);
    const Vec3 v(s.body.v_WB_W.x(), s.body.v_WB_W.y(), 0);
    Vec6 expected;
    expected << s.R_WB.transpose() * (-0.125 * 1.2 * 0.008 * length * v.norm() * v), Vec3::Zero();
    EXPECT_LT((wrench_of(kId, s, {0.008, 0.4, 0.9}) - expected).norm(), 1e-12);
    EXPECT_LT(power(s, wrench_of(kId, s, {0.008, 0.4, 0.9})), 0.0);  // takes energy
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(CableDrag, IsTheMomentBalanceOfACableAboutItsFloorPoint) {
  // 0.8 m of a 6 mm cable (C_D 1), its top at 2 m/s, its foot at rest: sum the drag piece by piece
  double moment = 0;
  const int pieces = 20000;
  for (int k = 0; k < pieces; ++k) {
    const double z = (k + 0.5) * 0.8 / pieces, v = 2.0 * z / 0.8;
    moment += z * 0.5 * 1.2 * 0.006 * v * v * (0.8 / pieces);
  }
  Situation s = hover(0.8);
  s.body.v_WB_W.x() = 2.0;
  EXPECT_NEAR(wrench_of(kId, s, {0.006, 0, 5})[0], -moment / 0.8, 1e-9);
}

}  // namespace
}  // namespace omniflight::physics::testing
