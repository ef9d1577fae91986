// What earns nothing on the flight as it was measured is not confirmed; what is there is, beside others too.
#include "../src/confirmed.hpp"

#include <gtest/gtest.h>

#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

/// On a flight in which `passed` act, of a model of com_offset and rotor_drag.
std::vector<std::string> refused(const std::vector<physics::ActiveEffect>& passed) {
  const vehicle::Vehicle v = test::omnimorph();
  Options o;
  o.tolerance.torque_trim = 0.001;
  test::Flown flown;
  flown.duration_s = 20;
  flown.sway = 0.25;
  auto flight = prepare_flight(test::fly(v, passed, flown), v, o);
  EXPECT_TRUE(flight);
  if (!flight) return {};
  flight->instrument = flight->smooth;
  const Flight* one[] = {&*flight};
  const Problem measured(one, v, o);
  const auto neutral = [](const char* id) {
    const physics::Effect* e = physics::find_effect(id);
    return physics::ActiveEffect{e, std::vector<double>(static_cast<std::size_t>(e->parameter_count()))};
  };
  const Fit model = fit_effects(measured, {neutral("com_offset"), neutral("rotor_drag")}, o);
  return unconfirmed(measured, model, 60, o);
}

TEST(Confirmed, WhatIsNotThereEarnsNothingBesideWhatIs) {
  const physics::ActiveEffect offset{physics::find_effect("com_offset"), {0.006, 0.004, 0.005}},
      drag{physics::find_effect("rotor_drag"), {2e-3}};
  EXPECT_EQ(refused({offset, drag}), std::vector<std::string>{});
  EXPECT_EQ(refused({offset}), std::vector<std::string>{"rotor_drag"});
  EXPECT_EQ(refused({drag}), std::vector<std::string>{"com_offset"});
}

TEST(Confirmed, TheLastOneIsNotTakenOut) {
  EXPECT_EQ(refused({}).size(), 1u) << "a model of one is what the search says it is";
}

}  // namespace
}  // namespace omniflight::diagnosis
