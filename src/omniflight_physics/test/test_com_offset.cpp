#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "com_offset";

TEST(ComOffset, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    // in the world: the acceleration of the true centre beyond that of the origin, and the lever of what it
    // takes to hold up and accelerate the mass
    const Vec3 c = s.R_WB * Vec3(0.006, -0.009, 0.02), w = s.R_WB * s.body.w_WB_B;
    const Vec3 a = s.R_WB * s.a_WB_B, dw = s.R_WB * s.dw_WB_B;
    const Vec3 force = -1.3 * (dw.cross(c) + w.cross(w.cross(c)));
    const Vec3 torque = -c.cross(1.3 * (a + Vec3(0, 0, kGravity)));
    Vec6 expected;
    expected << s.R_WB.transpose() * force, s.R_WB.transpose() * torque;
    EXPECT_LT((wrench_of(kId, s, {0.006, -0.009, 0.02}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(ComOffset, TipsTowardsTheHeavySideAndHeightShowsOnlyWhenTilted) {
  const Vec6 ahead = wrench_of(kId, hover(1.0), {0.01, 0, 0});
  EXPECT_NEAR(ahead[4], 1.3 * kGravity * 0.01, 1e-12) << "nose down is positive about y (left)";
  EXPECT_NEAR(wrench_of(kId, hover(1.0), {0, 0.01, 0})[3], -1.3 * kGravity * 0.01, 1e-12);
  EXPECT_EQ(wrench_of(kId, hover(1.0), {0, 0, 0.01}).norm(), 0.0);
  RigidState rolled;
  rolled.q_WB = exp_rotation(Vec3(0.5, 0, 0));
  const Situation s = situation(cube(), rolled, 0, std::vector<double>(8, 700.0));
  EXPECT_NEAR(wrench_of(kId, s, {0, 0, 0.01})[3], 1.3 * kGravity * 0.01 * std::sin(0.5), 1e-12)
      << "a high centre tips further over";
}

TEST(ComOffset, TakesTheEnergyThatTheDisplacedMassGains) {
  for (const Situation& s : six_states()) {
    // beyond a mass in the origin: m v.(w x c) of motion and m g (R c)_z of height
    const Vec3 c(0.006, -0.009, 0.02), &w = s.body.w_WB_B;
    const Vec3 rate = s.R_WB * w.cross(c), change = s.R_WB * (s.dw_WB_B.cross(c) + w.cross(w.cross(c)));
    const double gained =
        1.3 * ((s.R_WB * s.a_WB_B).dot(rate) + s.body.v_WB_W.dot(change) + kGravity * rate.z());
    EXPECT_NEAR(power(s, wrench_of(kId, s, {c.x(), c.y(), c.z()})), -gained, 1e-12);
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
