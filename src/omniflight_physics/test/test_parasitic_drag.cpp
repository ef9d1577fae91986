#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "parasitic_drag";

TEST(ParasiticDrag, IsTheHandFormulaInEveryFrame) {
  for (Situation s : six_states())
    for (const double density : {1.2, 0.9}) {
      s.environment.air_density = density;
      const Vec3& v = s.body.v_WB_W;
      const double pressure = 0.5 * density * v.squaredNorm();
      Vec6 expected;
      expected << s.R_WB.transpose() * (-0.02 * pressure * v.normalized()), Vec3::Zero();
      EXPECT_LT((wrench_of(kId, s, {0.02}) - expected).norm(), 1e-12);
      EXPECT_NEAR(power(s, wrench_of(kId, s, {0.02})), -0.02 * pressure * v.norm(), 1e-12);
      EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
    }
  EXPECT_EQ(wrench_of(kId, hover(1.0), {0.02}).norm(), 0.0) << "and nothing at rest";
}

}  // namespace
}  // namespace omniflight::physics::testing
