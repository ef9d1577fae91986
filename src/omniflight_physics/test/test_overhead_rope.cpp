#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "overhead_rope";
const std::vector<double> kTheta{0.08, 3.0, 3.4};  // kg/m, m, m

double carried(double h) { return std::clamp((kTheta[2] - kTheta[1] + h) / 2, 0.0, kTheta[2]); }

TEST(OverheadRope, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const double a = (s.R_WB * s.a_WB_B).z(), v = s.body.v_WB_W.z(), side = carried(s.body.p_WB.z());
    Vec6 expected;
    expected << s.R_WB.transpose() * Vec3(0, 0, -0.08 * side * (kGravity + a) - 0.02 * v * v), Vec3::Zero();
    EXPECT_LT((wrench_of(kId, s, kTheta) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(OverheadRope, TakesExactlyTheEnergyTheRopeGains) {
  // kinetic lambda s v^2/2 and weight: d/dh of the potential is lambda g s
  for (Situation s : six_states()) {
    const double v = s.body.v_WB_W.z(), a = (s.R_WB * s.a_WB_B).z(), h = s.body.p_WB.z();
    const auto energy = [&](double dt) {
      const double height = h + v * dt + a * dt * dt / 2, speed = v + a * dt, c = kTheta[2] - kTheta[1];
      return 0.5 * 0.08 * carried(height) * speed * speed +
             0.08 * kGravity * (c * height / 2 + height * height / 4);
    };
    const double dt = 1e-5, gained = (energy(dt) - energy(-dt)) / (2 * dt);
    EXPECT_NEAR(power(s, wrench_of(kId, s, kTheta)), -gained, 1e-7);
  }
}

TEST(OverheadRope, GrowsWithHalfTheSlopeOfAHungCableAndIsNothingWhenTaut) {
  const double slope = wrench_of(kId, hover(1.5), kTheta)[2] - wrench_of(kId, hover(1.0), kTheta)[2];
  const double hung = wrench_of("hung_cable", hover(1.5), {0.08, 0, 5})[2] -
                      wrench_of("hung_cable", hover(1.0), {0.08, 0, 5})[2];
  EXPECT_NEAR(slope / hung, 0.5, 1e-12);
  EXPECT_EQ(wrench_of(kId, hover(0.5), {0.08, 3.0, 2.0}).norm(), 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
