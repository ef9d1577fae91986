#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "cable_pendulum";
const std::vector<double> kTheta{0.2, 0.1, 1.15, 0.08};      // some states lift it off the floor
const std::vector<double> kSwinging{0.12, -0.07, 0.5, 0.3};  // m and m/s, world x and y
constexpr double kRoot = 2.404825557695773;                  // J0 is zero there

double hanging(const Situation& s) { return std::clamp(s.body.p_WB.z() - kTheta[1], 0.0, kTheta[2]); }

/// Six states that neither climb nor sink.
std::vector<Situation> level_states() {
  std::vector<Situation> out = six_states();
  for (Situation& s : out) {
    s.body.v_WB_W.z() = 0;
    s.v_WB_B = s.R_WB.transpose() * s.body.v_WB_W;
  }
  return out;
}

/// d2x [m/s^2] of the mode, world x and y.
Vec3 mode_acceleration(const Situation& s, const Vec3& x, const Vec3& dx) {
  const double wn = kRoot / 2 * std::sqrt(kGravity / hanging(s));
  const Vec3 a = s.R_WB * s.a_WB_B;
  Vec3 out = -a - 2 * 0.08 * wn * dx - wn * wn * x;
  out.z() = 0;
  return out;
}

TEST(CablePendulum, TheModeMovesByItsEquationInEveryFrame) {
  int lifted = 0;
  for (const Situation& s : level_states()) {
    const std::vector<double> rate = rate_of(kId, s, kTheta, kSwinging);
    const Vec3 expected = mode_acceleration(s, {0.12, -0.07, 0}, {0.5, 0.3, 0});
    EXPECT_EQ(rate[0], 0.5);
    EXPECT_EQ(rate[1], 0.3);
    EXPECT_NEAR(rate[2], expected.x(), 1e-12);
    EXPECT_NEAR(rate[3], expected.y(), 1e-12);
    lifted += hanging(s) == kTheta[2];
  }
  EXPECT_GT(lifted, 0);
  EXPECT_LT(lifted, 6);
}

TEST(CablePendulum, PullsWithTheMomentumThatItsOwnMotionNeedsInEveryFrame) {
  for (const Situation& s : level_states()) {
    // Nothing but the vehicle moves the cable sideways: its mode goes with a + d2x, the rest of its mass with
    // a.
    const double mass = 0.2 * hanging(s), mode = 4 / (kRoot * kRoot) * mass;
    const Vec3 a = s.R_WB * s.a_WB_B, swing = mode_acceleration(s, {0.12, -0.07, 0}, {0.5, 0.3, 0});
    const Vec3 f = -(mass - mode) * a - mode * (a + swing) - Vec3(0, 0, mass * kGravity);
    Vec6 expected;
    expected << s.R_WB.transpose() * f, Vec3::Zero();
    EXPECT_LT((remembered(kId, s, kTheta, kSwinging) - expected).norm(), 1e-12);
    EXPECT_EQ(remembered(kId, s, neutral_of(kId), kSwinging).norm(), 0.0);
    EXPECT_EQ(remembered(kId, s, {0.2, 2.5, 5, 0.08}, kSwinging).norm(), 0.0) << "all of it on the floor";
  }
}

TEST(CablePendulum, HasFrequencyAndMassOfTheFirstModeOfAHangingChain) {
  // The chain swings as J0(2 w sqrt(y/g)), y from its free end up, and is at rest at the vehicle, y = s.
  for (const Situation& s : level_states()) {
    Situation still = s;
    still.a_WB_B.setZero();
    const double square = -rate_of(kId, still, kTheta, {1, 0, 0, 0})[2];
    const double argument = 2 * std::sqrt(square * hanging(s) / kGravity);
    EXPECT_NEAR(std::cyl_bessel_j(0, argument), 0.0, 1e-12);
    EXPECT_LT(argument, 3.0) << "the first zero";
    // it moves with (int J0)^2 / int J0^2 of the mass, Simpson over y/s = z^2
    double sum = 0, squares = 0;
    const int n = 1000;
    for (int k = 0; k <= n; ++k) {
      const double z = static_cast<double>(k) / n, weight = k == 0 || k == n ? 1 : (k % 2 ? 4 : 2);
      const double shape = std::cyl_bessel_j(0, argument * z);
      sum += weight / (3 * n) * 2 * z * shape;
      squares += weight / (3 * n) * 2 * z * shape * shape;
    }
    const Vec3 pull = s.R_WB * remembered(kId, still, kTheta, {1, 0, 0, 0}).head<3>();
    EXPECT_NEAR(pull.x(), sum * sum / squares * 0.2 * hanging(s) * square, 1e-10);
  }
}

TEST(CablePendulum, SwingsAtItsFrequencyAndLosesItsDampingPerPeriod) {
  const Situation s = hover(1.1);  // 1 m hangs: 0.60 Hz
  for (const double zeta : {0.0, 0.05}) {
    const std::vector<double> theta{0.2, 0.1, 5, zeta};
    const double wn = kRoot / 2 * std::sqrt(kGravity / 1.0), root = std::sqrt(1 - zeta * zeta);
    const double period = 2 * kPi / (wn * root);
    EXPECT_NEAR(wn / (2 * kPi), 0.60, 0.005);
    Eigen::Vector4d x(0.1, -0.2, 0, 0);
    const auto rate = [&](const Eigen::Vector4d& at) -> Eigen::Vector4d {
      return Eigen::Vector4d(rate_of(kId, s, theta, {at[0], at[1], at[2], at[3]}).data());
    };
    const int n = 2000;
    const double h = period / n;
    for (int k = 0; k < n; ++k) {  // Runge-Kutta of fourth order
      const Eigen::Vector4d a = rate(x), b = rate(x + h / 2 * a), c = rate(x + h / 2 * b),
                            d = rate(x + h * c);
      x += h / 6 * (a + 2 * b + 2 * c + d);
    }
    const double left = std::exp(-2 * kPi * zeta / root);
    EXPECT_LT((x - left * Eigen::Vector4d(0.1, -0.2, 0, 0)).norm(), 1e-10);
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
