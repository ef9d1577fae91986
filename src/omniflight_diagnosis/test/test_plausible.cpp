// What values of an effect make sense on a vehicle, small or large.
#include <gtest/gtest.h>

#include <cmath>

#include "../src/plausible.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

vehicle::Vehicle crazyflie() {
  test::omnimorph();  // sets where vehicles are found
  auto v = vehicle::load_vehicle("crazyflie_brushless");
  EXPECT_TRUE(v) << v.error().text();
  return *v;
}

Range range_of(const char* id, std::size_t k, const VehicleScale& s) {
  return plausible_range(*physics::find_effect(id), k, s);
}

TEST(Plausible, EveryRangeLiesInTheCatalogueAndHoldsNothingAndTheOrdinary) {
  for (const vehicle::Vehicle& v : {test::omnimorph(), crazyflie()}) {
    const VehicleScale s = scale_of(v, 9.81);
    for (const physics::Effect* effect : physics::builtin_effects())
      for (std::size_t k = 0; k < effect->info().parameters.size(); ++k) {
        const physics::Parameter& p = effect->info().parameters[k];
        const auto [low, high] = plausible_range(*effect, k, s);
        EXPECT_GE(low, p.lower) << effect->info().id << " " << p.name;
        EXPECT_LE(high, p.upper) << effect->info().id << " " << p.name;
        EXPECT_LE(low, high) << effect->info().id << " " << p.name;
        if (!p.linear) continue;
        EXPECT_LE(low, p.neutral) << effect->info().id << " " << p.name;
        EXPECT_GE(high, p.neutral) << effect->info().id << " " << p.name;
      }
  }
  // the catalogue's ordinary values are meant for a vehicle of the size of the OmniMorph
  const VehicleScale s = scale_of(test::omnimorph(), 9.81);
  for (const char* id :
       {"rotor_drag", "axial_inflow", "blade_flapping", "thrust_curve", "rotor_position_error",
        "rotor_inertia", "drag_torque_scale", "parasitic_drag", "com_offset", "payload_mass"}) {
    const physics::Effect* effect = physics::find_effect(id);
    for (std::size_t k = 0; k < effect->info().parameters.size(); ++k) {
      const double typical = effect->info().parameters[k].typical;
      EXPECT_GT(typical, range_of(id, k, s).lower) << id;
      EXPECT_LT(typical, range_of(id, k, s).upper) << id;
    }
  }
}

TEST(Plausible, ASmallVehicleHasSmallLimits) {
  const VehicleScale s = scale_of(crazyflie(), 9.81);
  EXPECT_NEAR(s.rotor_thrust, 0.0907, 0.001);
  EXPECT_NEAR(s.rotor_speed, 1566, 20);
  EXPECT_LT(range_of("rotor_position_error", 0, s).upper, 0.01);  // rotors 46 mm from the middle
  EXPECT_LT(range_of("thrust_curve", 1, s).upper, 0.03);          // N, of 0.09 N
  const Range spin_up = range_of("rotor_inertia", 0, s);
  EXPECT_GT(spin_up.upper, 5e-7);  // 5e-8 is real: it must not count as being at a limit of either side
  EXPECT_LT(1e-3 * (spin_up.upper - spin_up.lower), 5e-9);
  EXPECT_GT(spin_up.lower, -1e-8);
}

TEST(Plausible, ARopeThatOnlyDampsIsNone) {
  const VehicleScale s = scale_of(crazyflie(), 9.81);
  const physics::Effect* rope = physics::find_effect("taut_rope");
  physics::ActiveEffect e{rope, {}};
  for (const physics::Parameter& p : rope->info().parameters) e.theta.push_back(p.typical);
  EXPECT_FALSE(contradicts_itself(e, s));
  e.theta[0] = 0.0015;  // N/m
  e.theta[1] = 0.013;   // N s/m
  EXPECT_TRUE(contradicts_itself(e, s));
}

/// Nothing is told of a spring so far from rest but that its torque hardly changes.
TEST(Plausible, ATorsionHalfATurnAwayIsAConstantTorque) {
  const VehicleScale s = scale_of(crazyflie(), 9.81);
  physics::ActiveEffect e{physics::find_effect("cable_torsion"), {0.003, 0, 0, 0.4}};
  EXPECT_FALSE(contradicts_itself(e, s));
  for (const double away : {-3.2, 3.2}) {
    e.theta[3] = away;
    EXPECT_TRUE(contradicts_itself(e, s)) << away;
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
