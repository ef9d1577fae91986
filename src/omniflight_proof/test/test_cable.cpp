// The articulated cable weighs what hangs, within 5 %, and shows on the free vehicle.
#include <algorithm>
#include <cmath>

#include "fixture.hpp"
#include "hung_mass.hpp"

namespace omniflight::proof {
namespace {

TEST(Cable, HungMassFollowsTheHeight) {
  World world;
  world.cable = Cable{.linear_density = 0.15, .length = 1.44, .links = 24};
  world.settle = 2;
  const auto measured =
      measure_hung_mass(omnimorph(), world, {.heights = {1.5, 1.2, 0.9}, .speed = 0.25, .pause = 1.0});
  ASSERT_TRUE(measured) << measured.error().text();
  ASSERT_EQ(measured->rests.size(), 5u);
  for (const auto& r : measured->rests) {
    EXPECT_NEAR(r.mass / r.expected, 1, 0.05) << r.height << (r.upward ? " up" : " down");
    std::printf("%.2f m %s: %.4f kg, law %.4f kg\n", r.height, r.upward ? "up" : "down", r.mass, r.expected);
  }
  EXPECT_NEAR(measured->rests[0].expected, 0.15 * (1.5 - 0.12), 1e-12);
}

TEST(Cable, HysteresisIsTheWidestGapBetweenDownAndUpOverTheLargestLaw) {
  // down by the law, up with 0.01 kg more below 1 m: a gap of 0.01 over a largest 0.2 kg
  HungMass made;
  for (int k = 0; k <= 200; ++k) {
    const double way = 0.01 * std::abs(100 - k), height = 0.6 + way;
    made.height.push_back(height);
    made.mass.push_back(0.125 * height + (k > 100 && height < 1 ? 0.01 : 0));
  }
  made.rests = {{1.6, 0.2, 0.2, false}, {0.6, 0.075, 0.075, false}, {1.6, 0.2, 0.2, true}};
  EXPECT_NEAR(made.hysteresis(), 0.05, 1e-3);
  for (std::size_t k = 0; k < made.mass.size(); ++k) made.mass[k] = 0.125 * made.height[k];
  EXPECT_LT(made.hysteresis(), 1e-3);
  EXPECT_EQ(HungMass{}.hysteresis(), 0);
}

TEST(Cable, LiesOnTheFloorAndNotInIt) {
  World world;
  world.cable = Cable{.length = 1.44, .links = 16};
  world.settle = 2;
  MujocoPlant plant = make(world, {.p_WB = Vec3(0, 0, 0.8)});
  const auto shape = plant.cable_shape();
  ASSERT_EQ(shape.size(), 17u);
  EXPECT_NEAR((shape.front() - Vec3(0, 0, 0.68)).norm(), 0, 1e-9);
  int lying = 0;
  for (const Vec3& p : shape) {
    EXPECT_GT(p.z(), 0.002);
    if (p.z() < 0.006) ++lying;
  }
  EXPECT_GE(lying, 7);
}

TEST(Cable, TheFreeVehicleFeelsIt) {
  World world;
  world.cable = Cable{.linear_density = 0.15, .length = 0.8, .links = 10};
  world.settle = 1;
  MujocoPlant plant = make(world, {.p_WB = Vec3(0, 0, 2)});  // hangs free
  plant.set_command(hover_speeds(plant.vehicle(), 1 + 0.12 / 1.315), 0);
  run(plant, 0.5, true);
  run(plant, 0.5, false);
  double mean = 0;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(plant.step());
    mean += plant.unmodelled_wrench()[2] / 200;
  }
  EXPECT_NEAR(mean, -0.12 * kGravity, 0.02);
  EXPECT_NEAR(plant.cable_force_W().z(), -0.12 * kGravity, 0.05);
  EXPECT_EQ(make({}).cable_force_W(), Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace omniflight::proof
