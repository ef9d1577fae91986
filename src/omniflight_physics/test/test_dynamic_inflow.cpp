#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "dynamic_inflow";
const std::vector<double> kTheta{2.1e-4, 0.03};

/// Induced velocity [m/s] of hover along -n: the momentum flux 2 rho A w |w| is the thrust.
double settled(const RotorSituation& r) {
  const double thrust = 4.76e-6 * r.speed * std::abs(r.speed);
  return std::copysign(std::sqrt(std::abs(thrust) / (2 * 1.2 * kPi * 0.1016 * 0.1016)), thrust);
}

/// Inflow [m/s] that has not settled; the seats of absent rotors are empty.
std::vector<double> inflow() {
  std::vector<double> w(16, 0.0);
  for (std::size_t i = 0; i < 8; ++i) w[i] = 6.0 - 1.3 * static_cast<double>(i);
  return w;
}

TEST(DynamicInflow, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const std::vector<double> w = inflow(), rate = rate_of(kId, s, kTheta, w);
    Vec6 expected = Vec6::Zero();
    for (std::size_t i = 0; i < 8; ++i) {
      const RotorSituation& r = s.rotors[i];
      const Vec3 f = -2.1e-4 * std::abs(r.speed) * (w[i] - settled(r)) * r.n_B;
      expected += at_hub(r, f, 0.0165 * r.spin * f);
      EXPECT_NEAR(0.03 * rate[i], settled(r) - w[i], 1e-12);
    }
    EXPECT_GT(expected.norm(), 0.1);
    EXPECT_LT((remembered(kId, s, kTheta, w) - expected).norm(), 1e-12);
    EXPECT_EQ(remembered(kId, s, neutral_of(kId), w).norm(), 0.0);
  }
}

TEST(DynamicInflow, StartsSettledAlsoWhereARotorRunsBackwards) {
  int reversed = 0;
  for (const Situation& s : six_states()) {
    std::vector<double> w(16, 1.0);
    find_effect(kId)->start_memory(s, kTheta.data(), w.data());
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_NEAR(w[i], settled(s.rotors[i]), 1e-12);
      reversed += w[i] < 0;
    }
    EXPECT_EQ(remembered(kId, s, kTheta, w).norm(), 0.0);
    for (const double rate : rate_of(kId, s, kTheta, w)) EXPECT_EQ(rate, 0.0);
  }
  EXPECT_EQ(reversed, 2);
}

}  // namespace
}  // namespace omniflight::physics::testing
