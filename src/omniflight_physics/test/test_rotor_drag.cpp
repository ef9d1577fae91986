#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "rotor_drag";

TEST(RotorDrag, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    // in the world, about the body origin
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 arm = s.R_WB * r.p_BR, n = s.R_WB * r.n_B;
      const Vec3 v = s.body.v_WB_W + (s.R_WB * s.body.w_WB_B).cross(arm);
      const Vec3 f = -std::abs(r.speed) * 1.2e-4 * (Mat3::Identity() - n * n.transpose()) * v;
      EXPECT_NEAR(f.dot(n), 0.0, 1e-12) << "in the plane of the disc";
      force += f;
      torque += arm.cross(f);
    }
    Vec6 expected;
    expected << s.R_WB.transpose() * force, s.R_WB.transpose() * torque;
    EXPECT_LT((wrench_of(kId, s, {1.2e-4}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(RotorDrag, BrakesATurnAboutTheAxisOfTheDiscs) {
  Situation s = hover(1.0);
  s.body.w_WB_B = Vec3(0, 0, 2);
  const Vec6 w = wrench_of(kId, s, {1.2e-4});
  EXPECT_NEAR(w[5], -8 * 2 * kPi * 120 * 1.2e-4 * 2 * (2 * 0.125 * 0.125), 1e-12);
  EXPECT_NEAR(w.head<3>().norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace omniflight::physics::testing
