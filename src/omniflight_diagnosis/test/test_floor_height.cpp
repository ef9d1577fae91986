// How far the floor is below a standing vehicle, by the ground effect itself.
#include "../src/conditioning/ground.hpp"
#include "../src/search/floor_height.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// A flight from 0.4 to 1.1 m above the floor of a vehicle with rotors of half a metre, which stood with its
/// hubs 1.1 radii above that floor.
Flight stood_high(const vehicle::Vehicle& v, double strength, std::uint64_t seed) {
  test::Flown flown;
  flown.seed = seed;
  flown.alpha = 0.2;
  flown.force_noise_N = 0.05;
  std::vector<physics::ActiveEffect> effects;
  if (strength > 0) effects.push_back({physics::find_effect("ground_effect"), {strength}});
  auto flight = prepare_flight(test::fly(v, effects, flown), v, {});
  EXPECT_TRUE(flight) << flight.error().text();
  EXPECT_FALSE(flight->stood_at) << "it never stood";
  flight->stood_at = 1.1 * mean_radius(v);
  set_floor_height(kLeastHubHeight * mean_radius(v), *flight);
  return *flight;
}

vehicle::Vehicle wide_rotors() {
  vehicle::Vehicle v = test::omnimorph();
  for (vehicle::Rotor& r : v.rotors) r.radius = 0.25;
  return v;
}

TEST(FloorHeight, IsWhereTheGroundEffectSays) {
  const vehicle::Vehicle v = wide_rotors();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    std::vector<Flight> flights{stood_high(v, 2, seed)};
    const auto height = hub_height(flights, v, {});
    ASSERT_TRUE(height) << seed;
    EXPECT_GE(*height, 0.69 * 0.25) << seed;
    EXPECT_LE(*height, 1.31 * 0.25) << seed;
    set_floor_height(*height, flights[0]);
    EXPECT_NEAR(flights[0].situation.front().environment.floor_z, *flights[0].stood_at - *height, 1e-12);
    EXPECT_NE(flights[0].notes.back().find("mm below where the vehicle stood"), std::string::npos);
  }
}

TEST(FloorHeight, StaysWhereNothingSpeaksForAnother) {
  const vehicle::Vehicle v = wide_rotors();
  for (const std::uint64_t seed : {1u, 2u, 3u})
    EXPECT_FALSE(hub_height({stood_high(v, 0, seed)}, v, {})) << seed;
  Flight told = stood_high(v, 2, 1);
  told.stood_at.reset();
  EXPECT_FALSE(hub_height({told}, v, {}));
  const double floor = told.floor_z;
  set_floor_height(0.3, told);
  EXPECT_EQ(told.floor_z, floor);
}

}  // namespace
}  // namespace omniflight::diagnosis
