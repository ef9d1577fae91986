// The catenary against its textbook relations, and against the forces that a potential gives.
#include "../src/catenary.hpp"

#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr double kStiff = 1e-9;  // 1/m, as good as inextensible

TEST(Catenary, BetweenTwoEndsKeepsItsLength) {
  // L^2 - dz^2 = (2 a sinh(dx / 2a))^2 for a cable that is lifted entirely
  for (const auto& [x, z] : {std::pair{1.0, 1.6}, {0.4, 1.95}, {1.4, 1.35}}) {
    const CatenaryEnds e = solve_catenary_ends(x, z, 2.0, kStiff);
    ASSERT_GT(e.b, 2.0) << "lifted: all its weight hangs on the upper end";
    const double sag = 2 * e.a * std::sinh(x / (2 * e.a));
    EXPECT_NEAR(4.0 - z * z, sag * sag, 1e-6);
  }
}

TEST(Catenary, OnTheFloorLiftsTheLengthOfTheCatenary) {
  // s = sqrt(h^2 + 2 h a), V = lambda g s, dx = a asinh(s/a) + L - s
  for (const double x : {1.3, 1.5, 1.7}) {
    const double h = 0.8;
    const CatenaryEnds e = solve_catenary_ends(x, h, 2.0, kStiff);
    ASSERT_LT(e.b, 2.0);
    EXPECT_NEAR(e.b, std::sqrt(h * h + 2 * h * e.a), 1e-8);
    EXPECT_NEAR(x, e.a * std::asinh(e.b / e.a) + 2.0 - e.b, 1e-8);
  }
}

TEST(Catenary, HangsStraightWhenItIsLongEnough) {
  const CatenaryEnds e = solve_catenary_ends(0.3, 0.9, 2.0, kStiff);
  EXPECT_EQ(e.a, 0.0);
  EXPECT_NEAR(e.b, 0.9, 1e-7);
}

TEST(Catenary, StretchesLikeASpringWhenTaut) {
  // far longer than its weight matters: tension EA times strain, here per weight: strain / e
  const double stretch = 1e-4, x = 1.64, z = 1.23;  // 2.05 m apart
  const CatenaryEnds e = solve_catenary_ends(x, z, 2.0, stretch);
  EXPECT_NEAR(std::hypot(e.a, e.b - 1.0), 0.025 / stretch, 0.01 * 0.025 / stretch);
  EXPECT_NEAR(e.a / (e.b - 1.0), x / z, 0.01);
}

TEST(Catenary, EveryGeometryHasAnAnswer) {
  Random rng(8);
  for (int k = 0; k < 2000; ++k) {
    const double x = rng.uniform(0, 5), z = rng.uniform(1e-3, 4), length = rng.uniform(0.1, 6);
    const double stretch = std::pow(10, rng.uniform(-6, -2));
    const CatenaryEnds e = solve_catenary_ends(x, z, length, stretch);
    if (e.a == 0) continue;
    const auto [x2, z2] = catenary_span(e.a, e.b, length, stretch);
    ASSERT_NEAR(x2, x, 1e-7 * (1 + x)) << length << " " << stretch;
    ASSERT_NEAR(z2, z, 1e-7 * (1 + z)) << length << " " << stretch;
  }
}

TEST(CatenaryEffect, PullsDownAndTowardsTheAnchorInEveryFrame) {
  const std::vector<double> theta{0.1, 2.5, 1.2, -0.4, 300};
  for (const Situation& s : six_states()) {
    const Vec3 to(1.2 - s.body.p_WB.x(), -0.4 - s.body.p_WB.y(), 0);
    const CatenaryEnds e = solve_catenary_ends(to.norm(), s.body.p_WB.z(), 2.5, kGravity / 9e4);
    const Vec3 f_W = 0.1 * kGravity * (e.a * to.normalized() - e.b * Vec3::UnitZ());
    EXPECT_LT((wrench_of("catenary", s, theta).head<3>() - s.R_WB.transpose() * f_W).norm(), 1e-7);
  }
}

TEST(CatenaryEffect, HasAPotentialSoThatARoundTripIsFree) {
  const std::vector<double> theta{0.1, 2.0, 0.8, 0.1, 300};
  double work = 0, way = 0;
  const int n = 4000;
  for (int k = 0; k < n; ++k) {
    const double phi = 2 * kPi * (k + 0.5) / n;
    RigidState body;
    body.p_WB = Vec3(0.6 * std::cos(phi), 0.5 * std::sin(phi), 1.0 + 0.4 * std::cos(phi + 1));
    const Vec3 ds = 2 * kPi / n * Vec3(-0.6 * std::sin(phi), 0.5 * std::cos(phi), -0.4 * std::sin(phi + 1));
    const Vec3 f =
        wrench_of("catenary", situation(cube(), body, 0, std::vector<double>(8, 0.0)), theta).head<3>();
    work += f.dot(ds);
    way += std::abs(f.dot(ds));
  }
  EXPECT_LT(std::abs(work), 1e-4 * way);
}

TEST(CatenaryEffect, HasTheDerivativeOfItsWrenchInEveryRegime) {
  const Effect* e = find_effect("catenary");
  for (const auto& [x, z, length] :
       {std::tuple{1.0, 1.6, 2.0}, {1.5, 0.8, 2.0}, {0.2, 0.9, 2.0}, {1.7, 1.3, 2.0}}) {
    RigidState body;
    body.p_WB = Vec3(0.1, 0.2, z);
    body.q_WB = exp_rotation(Vec3(0.3, -0.2, 0.5));
    const Situation s = situation(cube(), body, 0, std::vector<double>(8, 0.0));
    const std::vector<double> theta{0.1, length, 0.1 + 0.8 * x, 0.2 + 0.6 * x, 300};
    std::array<double, 6> value;
    std::array<double, 6 * kMaxParameters> J;
    e->wrench_with_jacobian(s, theta.data(), value.data(), J.data());
    for (std::size_t k = 0; k < theta.size(); ++k) {
      auto up = theta, down = theta;
      const double h = 1e-5 * std::max(0.1, theta[k]);
      up[k] += h;
      down[k] -= h;
      const Vec6 numeric = (wrench_of("catenary", s, up) - wrench_of("catenary", s, down)) / (2 * h);
      const Vec6 exact = Eigen::Map<const Vec6>(J.data() + 6 * k);
      EXPECT_LT((numeric - exact).norm(), 1e-5 * (1 + exact.norm())) << x << " " << k;
    }
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
