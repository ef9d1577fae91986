#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "axial_inflow";

TEST(AxialInflow, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    // in the world, about the body origin
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 arm = s.R_WB * r.p_BR, n = s.R_WB * r.n_B;
      const Vec3 v = s.body.v_WB_W + (s.R_WB * s.body.w_WB_B).cross(arm);
      const Vec3 f = -2.3e-4 * std::abs(r.speed) * n.dot(v) * n;
      force += f;
      torque += arm.cross(f);
    }
    Vec6 expected;
    expected << s.R_WB.transpose() * force, s.R_WB.transpose() * torque;
    EXPECT_LT((wrench_of(kId, s, {2.3e-4}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(AxialInflow, TakesThrustInAClimbAndGivesItInADescent) {
  Situation s = hover(1.0);
  for (const double climb : {-0.8, 0.8}) {
    s.v_WB_B = s.body.v_WB_W = Vec3(0, 0, climb);
    EXPECT_NEAR(wrench_of(kId, s, {2.3e-4})[2], -8 * 2.3e-4 * 2 * kPi * 120 * climb, 1e-12);
  }
  s.v_WB_B = s.body.v_WB_W = Vec3(1.5, -0.7, 0);
  EXPECT_EQ(wrench_of(kId, s, {2.3e-4}).norm(), 0.0) << "nothing along the discs";
}

}  // namespace
}  // namespace omniflight::physics::testing
