#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "hanging_start";

/// Work [J] on a body that bobs once about a height, z = middle + 0.1 sin(w t). The mean over the period is
/// exact for a smooth force.
double work_of_a_cycle(double middle, double damping_time) {
  const double w = 4.0;
  const int n = 400;
  double work = 0;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * kPi * k / n;
    Situation s = six_states()[4];  // turned: the force is the world's
    s.body.p_WB.z() = middle + 0.1 * std::sin(angle);
    s.body.v_WB_W = Vec3(0.3, -0.2, 0.1 * w * std::cos(angle));
    s.v_WB_B = s.R_WB.transpose() * s.body.v_WB_W;
    work += power(s, wrench_of(kId, s, {100, 1.4, damping_time})) * 2 * kPi / w / n;
  }
  return work;
}

TEST(HangingStart, TheSpringGivesBackWhatItTookAndTheDamperTakes) {
  EXPECT_NEAR(work_of_a_cycle(1.2, 0.0), 0.0, 1e-12);
  // k tau times the integral of the squared speed, A^2 w pi
  EXPECT_NEAR(work_of_a_cycle(1.2, 0.05), -100 * 0.05 * 0.1 * 0.1 * 4.0 * kPi, 1e-12);
  // half the time above its height: the damper takes on the whole way down, and on the way up until it is let
  // go
  const double half = 100 * 0.05 * 0.1 * 0.1 * 4.0 * kPi / 2;
  EXPECT_LT(work_of_a_cycle(1.4, 0.05), -half / 2);
  EXPECT_GT(work_of_a_cycle(1.4, 0.05), -half);
  EXPECT_EQ(work_of_a_cycle(1.6, 0.05), 0.0);
}

TEST(HangingStart, DampingTakesThePowerOfItsCoefficient) {
  int pulled = 0;
  for (Situation s : six_states()) {
    s.body.p_WB.z() = 1.1;
    const double v = s.body.v_WB_W.z();
    if (0.3 - 0.05 * v <= 0) continue;  // let go
    ++pulled;
    const double damped = power(s, wrench_of(kId, s, {100, 1.4, 0.05}));
    const double spring = power(s, wrench_of(kId, s, {100, 1.4, 0.0}));
    EXPECT_NEAR(spring, 100 * 0.3 * v, 1e-12);
    EXPECT_NEAR(damped - spring, -100 * 0.05 * v * v, 1e-12);
  }
  EXPECT_GE(pulled, 3);
}

}  // namespace
}  // namespace omniflight::physics::testing
