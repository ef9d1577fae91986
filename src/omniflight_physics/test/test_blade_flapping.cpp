#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "blade_flapping";

TEST(BladeFlapping, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    Vec3 torque = Vec3::Zero();  // in the world
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 n = s.R_WB * r.n_B;
      const Vec3 v = s.body.v_WB_W + (s.R_WB * s.body.w_WB_B).cross(s.R_WB * r.p_BR);
      torque += 3e-5 * std::abs(r.speed) * v.cross(n);
    }
    Vec6 expected;
    expected << Vec3::Zero(), s.R_WB.transpose() * torque;
    EXPECT_GT(expected.norm(), 1e-3);
    EXPECT_LT((wrench_of(kId, s, {3e-5}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(BladeFlapping, LeansBackFromTheWayItFlies) {
  // flown to the left, the left side lifts, a moment about +x (REP-103); straight up, nothing
  Situation s = hover(1.0);
  s.v_WB_B = s.body.v_WB_W = Vec3(0, 2, 0);
  EXPECT_NEAR(wrench_of(kId, s, {1e-6})[3], 8 * 1e-6 * 2 * kPi * 120 * 2, 1e-15);
  s.v_WB_B = s.body.v_WB_W = Vec3(0, 0, 2);
  EXPECT_EQ(wrench_of(kId, s, {1e-6}).norm(), 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
