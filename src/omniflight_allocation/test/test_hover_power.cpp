// Power of hovering: closed form, optimality, and the same answer as the zonotope on what is possible.
#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "omniflight_allocation/hover_power.hpp"
#include "omniflight_allocation/rotor_load.hpp"
#include "omniflight_core/random.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

Vec3 some_direction(Random& random) {
  return Vec3(random.normal(), random.normal(), random.normal()).normalized();
}

TEST(HoverPower, UprightWithoutTiltEveryRotorCarriesAnEighth) {
  const vehicle::Vehicle v = omnimorph();
  const auto cost = hover_cost(v, 0.0, Vec3::UnitZ());
  ASSERT_TRUE(cost) << cost.error().text();
  const double thrust = v.mass * kGravity / 8;
  ASSERT_TRUE(cost->possible);
  EXPECT_EQ(cost->working, 8);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(cost->u[i], thrust, 1e-5);
  const auto& r = v.rotors[0];
  EXPECT_NEAR(cost->power, 8 * r.drag_ratio * thrust * r.speed(thrust), 1e-3);
  EXPECT_NEAR(cost->largest_load, thrust / r.max_thrust, 1e-5);
}

/// Convex: stationary along every direction that leaves the wrench as it is, where no rotor is at a limit.
TEST(HoverPower, IsTheLeastOfAllThrustsThatCarryTheWeight) {
  const vehicle::Vehicle v = omnimorph();
  Random random(2);
  int compared = 0;
  for (int n = 0; n < 60; ++n) {
    const double alpha = random.uniform(to_radians(45), to_radians(60));
    const auto cost = hover_cost(v, alpha, some_direction(random));
    ASSERT_TRUE(cost);
    if (!cost->possible || cost->largest_load > 0.999) continue;
    ++compared;
    const Eigen::MatrixXd B = v.allocation_matrix(alpha);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(B, Eigen::ComputeFullV);
    const auto power = [&](const Eigen::VectorXd& u) {
      double sum = 0;
      for (int i = 0; i < 8; ++i) {
        const auto& r = v.rotors[static_cast<std::size_t>(i)];
        sum += r.drag_ratio * std::abs(u[i] * r.speed(u[i]));
      }
      return sum;
    };
    EXPECT_NEAR(power(cost->u), cost->power, 1e-9);
    for (int k = 6; k < 8; ++k)
      for (const double step : {-0.2, -0.05, 0.05, 0.2})  // N
        EXPECT_GT(power(cost->u + step * svd.matrixV().col(k)), cost->power - 1e-4) << n;
  }
  EXPECT_GT(compared, 40);
}

TEST(HoverPower, IsPossibleWhereTheZonotopeSaysSo) {
  const vehicle::Vehicle v = omnimorph(1.595, 5.95);
  Random random(3);
  int possible = 0, not_possible = 0;
  for (int n = 0; n < 300; ++n) {
    const double alpha = random.uniform(0, to_radians(60));
    const Vec3 up = some_direction(random);
    const double load = RotorLoad::create(v, alpha)->hover_load(Quat::FromTwoVectors(up, Vec3::UnitZ()));
    if (std::abs(load - 1) < 0.01) continue;
    EXPECT_EQ(hover_cost(v, alpha, up)->possible, load < 1) << load;
    ++(load < 1 ? possible : not_possible);
  }
  EXPECT_GT(possible, 50);
  EXPECT_GT(not_possible, 50);
}

TEST(HoverPower, TheMapHasTheWorstDirectionOfEveryLean) {
  const vehicle::Vehicle v = omnimorph();
  const double alpha = to_radians(54.7356), lean = 0.5 * kPi;
  const auto map = hover_map(v, {alpha}, {0.0, lean}, 8);
  ASSERT_TRUE(map);
  ASSERT_EQ(map->worst.size(), 2u);
  double most = 0;
  for (int k = 0; k < 8; ++k)
    most = std::max(
        most,
        hover_cost(v, alpha, Vec3(std::cos(k * kPi / 4), std::sin(k * kPi / 4), 0).normalized())->power);
  EXPECT_NEAR(map->worst[1][0].power, most, 1e-9);
  EXPECT_TRUE(map->worst[1][0].possible);
  EXPECT_FALSE(hover_map(v, {0.0}, {lean}, 4)->worst[0][0].possible) << "no force aside without tilt";
}

TEST(HoverPower, RefusesWhatIsNoDirection) {
  const vehicle::Vehicle v = omnimorph();
  EXPECT_FALSE(hover_cost(v, 0, Vec3::Zero()));
  EXPECT_FALSE(hover_cost(v, 0, Vec3(0, 0, std::nan(""))));
  EXPECT_FALSE(hover_cost(v, std::nan(""), Vec3::UnitZ()));
  EXPECT_FALSE(hover_map(v, {0}, {0}, 0));
}

}  // namespace
}  // namespace omniflight::allocation
