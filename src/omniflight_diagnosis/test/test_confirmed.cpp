// What earns nothing on the flight as it was measured is not confirmed; what is there is, beside others too.
#include "../src/confirmed.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// What is asked of a flight in which `passed` act, as it was measured.
template <class Ask>
auto of_flight(const std::vector<physics::ActiveEffect>& passed, const Ask& ask, bool duty_only = false) {
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  o.tolerance.torque_trim = 0.001;
  test::Flown flown;
  flown.duration_s = 20;
  flown.sway = 0.25;
  auto recording = test::fly(v, passed, flown);
  if (duty_only) test::drive_by_duty(recording, v, 1.0);
  auto flight = prepare_flight(recording, v, o);
  if (!flight) throw std::runtime_error(flight.error().text());
  flight->instrument = flight->smooth;
  const Flight* one[] = {&*flight};
  return ask(Problem(one, v, o), o);
}

/// Of a model of com_offset and rotor_drag.
std::vector<std::string> refused(const std::vector<physics::ActiveEffect>& passed) {
  const auto neutral = [](const char* id) {
    const physics::Effect* e = physics::find_effect(id);
    return physics::ActiveEffect{e, std::vector<double>(static_cast<std::size_t>(e->parameter_count()))};
  };
  return of_flight(passed, [&](const Problem& measured, const Options& o) {
    const Fit model = fit_effects(measured, {neutral("com_offset"), neutral("rotor_drag")}, o);
    return unconfirmed(measured, model, 60, o);
  });
}

/// Beside a model of nothing, of a weak thrust, a pull, rotors that have inertia and a rope.
std::string seen_at_once(const std::vector<physics::ActiveEffect>& passed, bool duty_only = false) {
  const auto ask = [&](const Problem& measured, const Options& o) {
    const std::vector<const physics::Effect*> candidates{
        physics::find_effect("thrust_scale"), physics::find_effect("constant_pull"),
        physics::find_effect("rotor_inertia"), physics::find_effect("taut_rope")};
    const physics::Effect* e = overlooked(measured, fit_effects(measured, {}, o), candidates, o);
    return e ? e->info().id : std::string();
  };
  return of_flight(passed, ask, duty_only);
}

TEST(Confirmed, WhatIsNotThereEarnsNothingBesideWhatIs) {
  const physics::ActiveEffect offset{physics::find_effect("com_offset"), {0.006, 0.004, 0.005}},
      drag{physics::find_effect("rotor_drag"), {2e-3}};
  EXPECT_EQ(refused({offset, drag}), std::vector<std::string>{});
  EXPECT_EQ(refused({offset}), std::vector<std::string>{"rotor_drag"});
  EXPECT_EQ(refused({drag}), std::vector<std::string>{"com_offset"});
}

TEST(Overlooked, OnlyWhatLeavesNextToNothingOfAChannel) {
  const auto pull = [](double x) {
    return physics::ActiveEffect{physics::find_effect("constant_pull"), {x, 0, 0}};
  };
  EXPECT_EQ(seen_at_once({}), "");
  EXPECT_EQ(seen_at_once({pull(0.15)}), "") << "as large as the noise: instruments tell";
  EXPECT_EQ(seen_at_once({pull(2.0)}), "constant_pull");
}

TEST(Overlooked, ARopeThatCatchesTheVehicleFarFromWhereItWouldBe) {
  const auto rope = [](double stiffness) {
    return physics::ActiveEffect{physics::find_effect("taut_rope"), {stiffness, 1, 0.9, 0.1, 0, 0, 0}};
  };
  EXPECT_EQ(seen_at_once({rope(30)}), "taut_rope");
  EXPECT_EQ(seen_at_once({rope(0.5)}), "") << "a law with bends may follow noise";
}

TEST(Overlooked, TorquesThatAreNotJudgedAreNotTaken) {
  EXPECT_EQ(seen_at_once({}, true), "") << "nothing of nothing is no share of it";
}

TEST(Confirmed, TheLastOneIsNotTakenOut) {
  EXPECT_EQ(refused({}).size(), 1u) << "a model of one is what the search says it is";
}

}  // namespace
}  // namespace omniflight::diagnosis
