// A rotor that is left out, and rotors that could tilt one by one.
#include <gtest/gtest.h>

#include "omniflight_allocation/allocator.hpp"
#include "omniflight_core/random.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

AllocationInput some_input(Random& rng) {
  AllocationInput in;
  for (int k = 0; k < 6; ++k) in.qdd_ref[k] = 0.7 * rng.normal();
  in.q_WB = exp_rotation(0.2 * Vec3(rng.normal(), rng.normal(), rng.normal()));
  return in;
}

/// m^2, of the rotors of OmniMorph from its centre of mass
constexpr double kSquareArm = 3 * 0.125 * 0.125;

/// The same thrusts as of a vehicle that never had the rotor and weighs rotation as translation at the
/// rotors, in all modes and units.
TEST(LostRotor, IsAsIfItHadNeverBeenThere) {
  const vehicle::Vehicle v = omnimorph();
  for (const TiltMode mode : {TiltMode::fixed, TiltMode::search}) {
    for (const bool gap : {false, true}) {
      AllocatorConfig config = AllocatorConfig::case_b();
      config.tilt_mode = mode;
      config.keep_min_thrust = gap;
      config.initial_tilt = to_radians(45);
      for (const int lost : {0, 5}) {
        vehicle::Vehicle rest = v;
        rest.rotors.erase(rest.rotors.begin() + lost);
        AllocatorConfig weighed = config;
        weighed.w_angular = kSquareArm * config.w_linear;
        auto with = Allocator::create(v, config).value(), without = Allocator::create(rest, weighed).value();
        ASSERT_TRUE(with.drop_rotor(lost));
        Random rng(7);
        for (int i = 0; i < 100; ++i) {
          const AllocationInput in = some_input(rng);
          const auto a = with.allocate(in), b = without.allocate(in);
          ASSERT_TRUE(a && b);
          ASSERT_EQ(a->u[lost], 0) << i;
          ASSERT_EQ(a->speed[lost], 0);
          vehicle::RotorVector others(v.rotor_count() - 1);
          for (int k = 0, m = 0; k < v.rotor_count(); ++k)
            if (k != lost) others[m++] = a->u[k];
          ASSERT_LT((others - b->u).norm(), 1e-6) << i;
          ASSERT_DOUBLE_EQ(a->alpha, b->alpha);
          ASSERT_LT((a->qdd - b->qdd).norm(), 1e-6);
        }
      }
    }
  }
}

/// What the controller asks 0.13 s after rotor 1 has died, in a flight that turned over: with the usual
/// weights the others keep the vehicle in its place and turn it the other way about z.
TEST(LostRotor, TheOthersTurnTheVehicleBackBeforeTheyKeepItInItsPlace) {
  AllocationInput in;
  in.qdd_ref << -0.9, 0.4, 1.6, 38.8, -60.0, 30.2;
  in.alpha = to_radians(30);
  auto allocator = Allocator::create(omnimorph(), AllocatorConfig::case_a()).value();
  ASSERT_TRUE(allocator.drop_rotor(0));
  const auto out = allocator.allocate(in);
  ASSERT_TRUE(out);
  for (int k = 3; k < 6; ++k) EXPECT_GT(out->qdd[k] / in.qdd_ref[k], 0.5) << k;
  EXPECT_LT((out->qdd - in.qdd_ref).head<3>().norm(), 6.0) << "m/s^2";
  in.qdd_ref.setZero();
  EXPECT_LT(allocator.allocate(in)->qdd.norm(), 1e-3) << "hovering needs no such choice";
}

TEST(LostRotor, OneThatMustTurnForwardStandsToo) {
  vehicle::Vehicle v = omnimorph();
  v.tilt = {};
  for (auto& r : v.rotors) r.bidirectional = false, r.min_thrust = 0.5;
  AllocatorConfig config;
  config.tilt_mode = TiltMode::fixed;
  auto allocator = Allocator::create(v, config).value();
  ASSERT_TRUE(allocator.drop_rotor(2));
  const auto out = allocator.allocate({});
  ASSERT_TRUE(out);
  EXPECT_EQ(out->u[2], 0);
  for (const int k : {0, 1, 3, 4, 5, 6, 7}) EXPECT_GE(out->u[k], 0.5 - 1e-12);
}

TEST(LostRotor, TheLastOneAndOneThatThereIsNotAreRefused) {
  auto allocator = Allocator::create(omnimorph(), AllocatorConfig::case_a()).value();
  EXPECT_FALSE(allocator.drop_rotor(-1));
  EXPECT_FALSE(allocator.drop_rotor(8));
  for (int k = 0; k < 7; ++k) EXPECT_TRUE(allocator.drop_rotor(k));
  const auto last = allocator.drop_rotor(7);
  ASSERT_FALSE(last);
  EXPECT_NE(last.error().text().find("no rotor is left"), std::string::npos);
}

TEST(IndividualTilt, IsFlownAsACommonOne) {
  vehicle::Vehicle v = omnimorph();
  auto common = Allocator::create(v, AllocatorConfig::case_b()).value();
  v.tilt.kind = vehicle::TiltKind::individual;
  auto individual = Allocator::create(v, AllocatorConfig::case_b()).value();
  Random rng(3);
  for (int i = 0; i < 50; ++i) {
    const AllocationInput in = some_input(rng);
    const auto a = common.allocate(in), b = individual.allocate(in);
    ASSERT_TRUE(a && b);
    EXPECT_DOUBLE_EQ(a->alpha, b->alpha);
    EXPECT_EQ(a->u, b->u);
  }
}

}  // namespace
}  // namespace omniflight::allocation
