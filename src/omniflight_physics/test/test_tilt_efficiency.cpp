#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "tilt_efficiency";

TEST(TiltEfficiency, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const double eta = (1 - 0.4) + 0.25 * s.alpha;
    Vec6 expected = Vec6::Zero();
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 lost = (eta - 1) * 4.76e-6 * r.speed * std::abs(r.speed) * r.n_B;
      expected += at_hub(r, lost, 0.0165 * r.spin * lost);
    }
    EXPECT_LT((wrench_of(kId, s, {0.4, 0.25}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(TiltEfficiency, IsAStraightLineThroughTwoMultipliers) {
  // 0.35 left at 0 deg and 0.70 at 60 deg, one reading of section 5.3 of the thesis
  const std::vector<double> theta{0.65, 0.35 / (kPi / 3)};
  for (const auto& [alpha, eta] : {std::pair{0.0, 0.35}, {kPi / 6, 0.525}, {kPi / 3, 0.70}}) {
    const Situation s = hover(1.0, alpha);
    EXPECT_LT((rotor_wrench(s) + wrench_of(kId, s, theta) - eta * rotor_wrench(s)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
