// Thrust that departs from the quadratic law: single rotors, reversed rotors, other exponents.
#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

/// Wrench of thrust changes dT [N], one a rotor.
Vec6 of_changes(const Situation& s, const std::vector<double>& dT) {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < dT.size(); ++i) {
    const RotorSituation& r = s.rotors[i];
    sum += at_hub(r, dT[i] * r.n_B, r.spin * r.drag_ratio * dT[i] * r.n_B);
  }
  return sum;
}

TEST(RotorThrustScale, IsTheHandFormulaInEveryFrame) {
  const std::vector<double> eps{-0.5, 0.1, 0, 0.02, -0.03, 0.2, 0, 0.07};
  for (const Situation& s : six_states()) {
    std::vector<double> dT;
    for (std::size_t i = 0; i < 8; ++i) dT.push_back(eps[i] * s.rotors[i].thrust);
    EXPECT_LT((wrench_of("rotor_thrust_scale", s, eps) - of_changes(s, dT)).norm(), 1e-12);
    EXPECT_LT((wrench_of("rotor_thrust_scale", s, std::vector<double>(8, 0.1)) -
               wrench_of("thrust_scale", s, {0.1}))
                  .norm(),
              1e-12);  // all alike is the common scale
  }
}

TEST(ReverseThrustAsymmetry, TouchesReversedRotorsOnly) {
  for (const Situation& s : six_states()) {
    std::vector<double> dT(8, 0.0);
    for (std::size_t i = 0; i < 8; ++i)
      if (s.rotors[i].speed < 0) dT[i] = -0.25 * s.rotors[i].thrust;
    EXPECT_LT((wrench_of("reverse_thrust_asymmetry", s, {-0.25}) - of_changes(s, dT)).norm(), 1e-12);
  }
  EXPECT_EQ(wrench_of("reverse_thrust_asymmetry", hover(1), {-0.25}).norm(), 0.0);
}

TEST(ThrustCurve, IsTheHandFormulaAndOddInSpeed) {
  for (const Situation& s : six_states()) {
    std::vector<double> dT;
    for (std::size_t i = 0; i < 8; ++i) {
      const double w = s.rotors[i].speed;
      dT.push_back((3e-4 * std::abs(w) + 0.1) * w / std::sqrt(w * w + 100));
    }
    EXPECT_LT((wrench_of("thrust_curve", s, {3e-4, 0.1}) - of_changes(s, dT)).norm(), 1e-12);
  }
  const Vec6 forth = wrench_of("thrust_curve", hover(1, 0, 500), {3e-4, 0.1});
  const Vec6 back = wrench_of("thrust_curve", hover(1, 0, -500), {3e-4, 0.1});
  EXPECT_LT((forth + back).norm(), 1e-12);
  EXPECT_EQ(wrench_of("thrust_curve", hover(1, 0, 0), {3e-4, 0.1}).norm(), 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
