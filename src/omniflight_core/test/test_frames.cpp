#include <gtest/gtest.h>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight {
namespace {

Vec3 random_vector(Random& rng, double scale) {
  return scale * Vec3(rng.normal(), rng.normal(), rng.normal());
}

TEST(Frames, SkewIsTheCrossProduct) {
  Random rng(1);
  const Vec3 a = random_vector(rng, 1), b = random_vector(rng, 1);
  EXPECT_LT((skew(a) * b - a.cross(b)).norm(), 1e-15);
  EXPECT_LT((vee(skew(a)) - a).norm(), 1e-15);
}

TEST(Frames, LogInvertsExp) {
  Random rng(2);
  for (int i = 0; i < 200; ++i) {
    Vec3 phi = random_vector(rng, i < 100 ? 1e-6 : 1.0);
    if (phi.norm() > 3.0) phi *= 3.0 / phi.norm();
    EXPECT_LT((log_rotation(exp_rotation(phi)) - phi).norm(), 1e-12);
  }
}

TEST(Frames, JacobianRateIsTheRestOfTheAngularAcceleration) {
  // phi(t) = phi + d t + 1/2 a t^2; the body rate by differences of the rotation itself, its rate likewise
  Random rng(5);
  for (int i = 0; i < 50; ++i) {
    const Vec3 phi = random_vector(rng, 0.8), d = random_vector(rng, 1.0), a = random_vector(rng, 1.0);
    const auto rotation = [&](double t) { return exp_rotation(phi + d * t + 0.5 * a * t * t); };
    const double e = 1e-3;
    const auto rate = [&](double t) {
      return Vec3(log_rotation(rotation(t - 0.5 * e).conjugate() * rotation(t + 0.5 * e)) / e);
    };
    const Vec3 numeric = (rate(e) - rate(-e)) / (2 * e);
    EXPECT_LT((right_jacobian(phi) * a + jacobian_rate_times(phi, d) - numeric).norm(),
              2e-5 * (1 + numeric.norm()));
  }
}

TEST(Frames, JacobianRateIsTheDerivativeOfTheJacobianNearZeroAndFarFromIt) {
  Random rng(6);
  for (const double size : {1e-9, 1e-3, 0.0999, 0.1001, 1.0, 3.0})
    for (int i = 0; i < 20; ++i) {
      const Vec3 phi = size * random_vector(rng, 1.0).normalized(), d = random_vector(rng, 1.0);
      const double e = 1e-4;
      const Vec3 numeric = (right_jacobian(phi + e * d) * d - right_jacobian(phi - e * d) * d) / (2 * e);
      EXPECT_LT((jacobian_rate_times(phi, d) - numeric).norm(),
                1e-7 * (1 + d.squaredNorm() * d.squaredNorm()))
          << size;
    }
}

TEST(Frames, RightJacobianIsTheDerivativeOfExp) {
  Random rng(3);
  for (int i = 0; i < 50; ++i) {
    const Vec3 phi = random_vector(rng, 0.8), d = random_vector(rng, 1.0);
    const double e = 1e-6;
    const Vec3 numeric =
        log_rotation(exp_rotation(phi - e * d).conjugate() * exp_rotation(phi + e * d)) / (2 * e);
    EXPECT_LT((right_jacobian(phi) * d - numeric).norm(), 1e-8);
    EXPECT_LT((right_jacobian_inverse(phi) * right_jacobian(phi) - Mat3::Identity()).norm(), 1e-12);
  }
}

TEST(Frames, RollPitchYawRoundTrip) {
  const Vec3 rpy(0.3, -0.7, 2.1);
  EXPECT_LT((roll_pitch_yaw(from_roll_pitch_yaw(rpy)) - rpy).norm(), 1e-14);
}

TEST(RigidState, NamesTheComponentThatIsNotFinite) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  RigidState s;
  EXPECT_EQ(what_is_not_finite(s), "");
  const auto names = [&s](const char* words) {
    EXPECT_EQ(what_is_not_finite(s), words);
    EXPECT_FALSE(is_finite(s)) << words;
  };
  s.q_WB.coeffs() *= 0.1;
  names("attitude has the length 0.100000 instead of 1");
  s.q_WB = Quat(1, 0, nan, 0);
  names("attitude qy is nan");
  s.w_WB_B.z() = -infinity;
  names("angular velocity z is -inf rad/s");
  s.v_WB_W.y() = nan;
  names("velocity y is nan m/s");
  s.p_WB.x() = infinity;
  names("position x is inf m");
}

TEST(Random, IsTheSameEverywhereAndStandardNormal) {
  Random rng(42, "imu");
  Random again(42, "imu"), other(42, "mocap");
  EXPECT_EQ(rng.next(), again.next());
  EXPECT_NE(rng.next(), other.next());
  double sum = 0.0, sum2 = 0.0;
  constexpr int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double x = rng.normal();
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.01);
  EXPECT_NEAR(sum2 / n, 1.0, 0.01);
}

}  // namespace
}  // namespace omniflight
