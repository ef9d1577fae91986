#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "ceiling_effect";

TEST(CeilingEffect, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    Vec6 expected = Vec6::Zero();
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 push = s.R_WB * r.n_B * (r.thrust < 0 ? -1.0 : 1.0);
      const double gap = std::max(0.05 * r.radius, 1.6 - (s.body.p_WB + s.R_WB * r.p_BR).z());
      const double v = std::sqrt(std::abs(r.thrust) / (2 * 1.2 * kPi * r.radius * r.radius));
      const double slower = 1 - 1 / std::sqrt(1 + std::pow(r.radius / gap, 2) / 32);
      const double dT = 3e-4 * std::abs(r.speed) * v * slower * std::max(0.0, push.z());
      expected += at_hub(r, s.R_WB.transpose() * (dT * push));
    }
    EXPECT_LT((wrench_of(kId, s, {3e-4, 1.6}) - expected).norm(), 1e-12);
  }
  EXPECT_EQ(wrench_of(kId, six_states()[0], neutral_of(kId)).norm(), 0.0);
}

TEST(CeilingEffect, TheInducedVelocityIsThatOfTheMomentumBalance) {
  // Disc of radius R at a gap d below a plate, uniform velocity v through it. Continuity: the air in the gap
  // moves inwards with v r/(2d). Bernoulli above and below gives the thrust, momentum with the suction on the
  // plate the far wake w; the suction is integrated here ring by ring.
  const double R = 0.1, rho = 1.2, area = kPi * R * R, thrust = 3.0;
  for (const double gap : {0.2, 0.05, 0.01}) {
    double radial = 0;  // mean of the squared radial velocity over the disc, for v = 1
    const int rings = 20000;
    for (int k = 0; k < rings; ++k) {
      const double r = (k + 0.5) * R / rings;
      radial += std::pow(r / (2 * gap), 2) * 2 * kPi * r * (R / rings) / area;
    }
    double low = 0, high = 20;  // v with this thrust
    for (int k = 0; k < 80; ++k) {
      const double v = 0.5 * (low + high);
      const double suction = 0.5 * rho * radial * v * v * area;
      // momentum: rho A v w = thrust - suction; Bernoulli: thrust = rho A w^2/2 + suction
      const double wake = 2 * v;
      EXPECT_NEAR(rho * area * v * wake, 0.5 * rho * area * wake * wake, 1e-9);
      (0.5 * rho * area * wake * wake + suction < thrust ? low : high) = v;
    }
    const double free = std::sqrt(thrust / (2 * rho * area));
    EXPECT_NEAR(low / free, 1 / std::sqrt(1 + std::pow(R / gap, 2) / 32), 1e-6);
  }
}

TEST(CeilingEffect, PullsUpMoreTheCloserButOnlyRotorsThatLookUp) {
  const double near = wrench_of(kId, hover(1.95), {2.1e-4, 2.2})[2],
               far = wrench_of(kId, hover(1.2), {2.1e-4, 2.2})[2];
  EXPECT_GT(near, 10 * far);
  EXPECT_GT(far, 0.0);
  RigidState upside_down;
  upside_down.p_WB.z() = 1.95;
  upside_down.q_WB = exp_rotation(Vec3(kPi, 0, 0));
  const Situation s = situation(cube(), upside_down, 0.0, std::vector<double>(8, 754.0));
  EXPECT_EQ(wrench_of(kId, s, {2.1e-4, 2.2}).norm(), 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
