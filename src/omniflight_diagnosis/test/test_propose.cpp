#include <gtest/gtest.h>

#include <algorithm>

#include "../src/manoeuvres.hpp"
#include "../src/propose.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

const ProposedFlight* find(const std::vector<ProposedFlight>& flights, const std::string& name) {
  const auto at =
      std::find_if(flights.begin(), flights.end(), [&](const ProposedFlight& f) { return f.name == name; });
  return at == flights.end() ? nullptr : &*at;
}

/// m (a + g) = k F in every motion of the centre of mass: only torques tell a load from a weak thrust.
TEST(Propose, RockingTellsALoadFromWeakThrustAndClimbingDoesNot) {
  const vehicle::Vehicle v = test::omnimorph();
  const recording::Recording r = test::fly(v, {{physics::find_effect("payload_mass"), {0.1}}}, {});
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_EQ(d->verdict, Verdict::ambiguous) << d->summary;
  const auto& pairs = d->next_flight.separates;
  const auto pair = std::find_if(pairs.begin(), pairs.end(), [](const auto& p) {
    return p == std::pair<std::string, std::string>("payload_mass", "thrust_scale");
  });
  ASSERT_NE(pair, pairs.end()) << d->summary;
  const auto k = static_cast<std::size_t>(pair - pairs.begin());
  const auto& flights = d->next_flight.proposed;
  const ProposedFlight *climb = find(flights, "ascent_with_pauses"),
                       *rock = find(flights, "rocking_at_three_heights");
  ASSERT_TRUE(climb && rock);
  ASSERT_EQ(rock->separations_sigma.size(), pairs.size());
  printf("payload against thrust scale: climbing %.2f sigma, rocking %.2f sigma\n",
         climb->separations_sigma[k], rock->separations_sigma[k]);
  EXPECT_LT(climb->separations_sigma[k], 3);
  EXPECT_GT(rock->separations_sigma[k], 4);
  EXPECT_EQ(flights.front().name.rfind("rocking", 0), 0u) << flights.front().name;
}

/// Only what accelerates the mass itself tells a load from a pull.
TEST(Propose, HeavingTellsALoadFromAPullAndClimbingDoesNot) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const physics::ActiveEffect load{physics::find_effect("payload_mass"), {0.02}},
      pull{physics::find_effect("constant_pull"), {0, 0, -0.02 * 9.81}};
  const auto flight = prepare_flight(test::fly(v, {load}, {}), v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  const Problem problem(one, v, o);
  const auto flights = propose_flights(problem, *flight, v, {{load, pull}}, o);
  const ProposedFlight *climb = find(flights, "ascent_with_pauses"),
                       *heave = find(flights, "rocking_at_three_heights");
  ASSERT_TRUE(climb && heave);
  printf("load against pull: climbing %.2f sigma, heaving %.2f sigma\n", climb->separation_sigma,
         heave->separation_sigma);
  EXPECT_LT(climb->separation_sigma, 1.5);
  EXPECT_GT(heave->separation_sigma, 2.5 * climb->separation_sigma);
  EXPECT_LE(heave->acceleration, 3.7);
}

/// A thrust that changes with the tilt can be a weak thrust, on every flight: what counts is whether its
/// further number would show.
TEST(Propose, MovingTheTiltTellsAWeakThrustFromOneThatChangesWithIt) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const physics::ActiveEffect weak{physics::find_effect("thrust_scale"), {-0.05}},
      by_tilt{physics::find_effect("tilt_efficiency"), {0.05, 0.0}};
  const auto flight = prepare_flight(test::fly(v, {weak}, {}), v, o);
  ASSERT_TRUE(flight) << flight.error().text();
  const Flight* one[] = {&*flight};
  const Problem problem(one, v, o);
  const auto flights = propose_flights(problem, *flight, v, {{weak, by_tilt}}, o);
  const ProposedFlight *still = find(flights, "rocking_at_three_heights"),
                       *moving = find(flights, "rocking_and_tilting");
  ASSERT_TRUE(still && moving);
  printf("weak thrust against one that changes with the tilt: one tilt %.2f sigma, three %.2f sigma\n",
         still->separation_sigma, moving->separation_sigma);
  EXPECT_LT(still->separation_sigma, 1);
  EXPECT_GT(moving->separation_sigma, 5);
}

/// Any of a set may be the true one, so that all of it has to be told apart, not the named one alone.
TEST(Propose, EveryTwoOfASetAreToBeToldApart) {
  const physics::ActiveEffect tilt{physics::find_effect("tilt_offset"), {0.01}};
  Naming naming;
  naming.model.effects = {tilt};
  naming.named.emplace_back();
  naming.named[0].set = {{"payload_mass", {0.01}, 1.0, 0.9}, {"thrust_scale", {-0.01}, 1.0, 0.9}};
  naming.named[0].alike = {{"constant_pull", {0, 0, -0.1}, 2.0, 0.99}};
  std::vector<std::string> pairs;
  for (const Rivals& pair : rivals_of(naming, 0))
    pairs.push_back(pair.named.effect->info().id + " " + pair.other.effect->info().id);
  EXPECT_EQ(pairs, (std::vector<std::string>{"tilt_offset payload_mass", "tilt_offset thrust_scale",
                                             "tilt_offset constant_pull", "payload_mass thrust_scale",
                                             "payload_mass constant_pull", "thrust_scale constant_pull"}));
  NextFlight next;
  next.separates = {{"tilt_offset", "payload_mass"}, {"payload_mass", "thrust_scale"}, {"a", "b"}};
  next.separations_sigma = {13.5, 2.14};  // of the third pair nothing is predicted
  EXPECT_EQ(stay_together(next), "payload_mass and thrust_scale (2.1 sigma)");
  next.separations_sigma[1] = 7;
  EXPECT_EQ(stay_together(next), "");
}

TEST(Propose, ManoeuvresEndAtRestNeverSinkBelowTheirStartAndKeepToTheTiltRange) {
  const vehicle::Vehicle v = test::omnimorph();
  for (const double alpha : {v.tilt.min, 0.5, v.tilt.max})
    for (const ProposedFlight& f : manoeuvres(v, alpha)) {
      EXPECT_GE(f.alpha, v.tilt.min) << f.name;
      EXPECT_LE(f.alpha, v.tilt.max) << f.name;
      EXPECT_FALSE(f.words.empty());
      ASSERT_FALSE(f.waypoints.empty());
      EXPECT_GT(f.waypoints.back().hold_s, 0) << f.name << " ends in motion";
      double height = 0;
      for (const ProposedWaypoint& w : f.waypoints) EXPECT_GE(height += w.by.z(), -1e-9) << f.name;
    }
}

}  // namespace
}  // namespace omniflight::diagnosis
