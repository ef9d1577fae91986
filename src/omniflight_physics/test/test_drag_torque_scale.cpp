#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "drag_torque_scale";

/// Torque [Nm, world] of air on a rotor, by coefficients: it goes to the body.
Vec3 air_torque(const Situation& s, const RotorSituation& r) {
  return s.R_WB * (0.0165 * r.spin * 4.76e-6 * r.speed * std::abs(r.speed) * r.n_B);
}

TEST(DragTorqueScale, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    Vec3 torque = Vec3::Zero();
    for (const RotorSituation& r : s.all_rotors()) torque += 0.3 * air_torque(s, r);
    Vec6 expected;
    expected << Vec3::Zero(), s.R_WB.transpose() * torque;
    EXPECT_GT(torque.norm(), 1e-4);
    EXPECT_LT((wrench_of(kId, s, {0.3}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(DragTorqueScale, RotorsDrawThePowerOfTheTorqueTheyTurnAgainst) {
  for (const Situation& s : six_states())
    for (const double eps : {0.3, -0.4}) {
      // a rotor of spin +1 turns about -n, against the torque of the air, forwards and reversed
      double drawn = 0;
      for (const RotorSituation& r : s.all_rotors())
        drawn += eps * air_torque(s, r).dot(s.R_WB * (r.spin * r.speed * r.n_B));
      EXPECT_GT(drawn / eps, 0.0);
      EXPECT_NEAR(find_effect(kId)->shaft_power(s, &eps), drawn, 1e-12 * std::abs(drawn));
    }
}

TEST(DragTorqueScale, PushesAlongTheAxisOfAPositiveSpinAndBackWhenReversed) {
  Situation s = hover(1.0);
  for (auto& r : s.rotors)
    if (r.spin < 0) r.speed = r.thrust = 0;
  const double one = 0.0165 * 4.76e-6 * std::pow(2 * kPi * 120, 2);
  EXPECT_NEAR(wrench_of(kId, s, {0.1})[5], 0.1 * 4 * one, 1e-12);
  Situation reversed = hover(1.0, 0.0, -2 * kPi * 120);
  for (auto& r : reversed.rotors)
    if (r.spin < 0) r.speed = r.thrust = 0;
  EXPECT_NEAR(wrench_of(kId, reversed, {0.1})[5], -0.1 * 4 * one, 1e-12);
}

}  // namespace
}  // namespace omniflight::physics::testing
