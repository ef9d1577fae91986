#include <gtest/gtest.h>

#include <algorithm>

#include "../src/evidence/noise_estimate.hpp"
#include "../src/experiment_design/manoeuvres.hpp"
#include "../src/experiment_design/propose.hpp"
#include "../src/regression/predetermined.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

const ProposedFlight* find(const std::vector<ProposedFlight>& flights, const std::string& name) {
  const auto at =
      std::find_if(flights.begin(), flights.end(), [&](const ProposedFlight& f) { return f.name == name; });
  return at == flights.end() ? nullptr : &*at;
}

/// What would tell this pair apart after this flight.
std::vector<ProposedFlight> proposed(const vehicle::Vehicle& v, const physics::ActiveEffect& flown,
                                     const Rivals& pair, const Options& o = {}) {
  const auto flight = prepare_flight(test::fly(v, {flown}, {}), v, o);
  EXPECT_TRUE(flight) << flight.error().text();
  if (!flight) return {};
  const Flight* one[] = {&*flight};
  const RegressionProblem problem(one, v, o, Horizon{least_horizon(*flight)});
  const auto noise =
      estimate_noise(problem, slow_columns(problem), Eigen::VectorXd::Zero(problem.rows()), o.temperature);
  return propose_flights(problem, *noise, *flight, v, {pair}, o);
}

/// m (a + g) = k F in every motion of the centre of mass: only torques tell a load from a weak thrust.
TEST(Propose, RockingTellsALoadFromWeakThrustAndClimbingDoesNot) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::ActiveEffect load{physics::find_effect("payload_mass"), {0.1}},
      weak{physics::find_effect("thrust_scale"), {-0.1 / (v.mass + 0.1)}};
  const auto flights = proposed(v, load, {load, weak});
  const ProposedFlight *climb = find(flights, "ascent_with_pauses"),
                       *rock = find(flights, "rocking_at_three_heights");
  ASSERT_TRUE(climb && rock);
  printf("payload against thrust scale: climbing %.2f sigma, rocking %.2f sigma\n", climb->separation_sigma,
         rock->separation_sigma);
  EXPECT_LT(climb->separation_sigma, 3);
  EXPECT_GT(rock->separation_sigma, 4);
  EXPECT_EQ(flights.front().name.rfind("rocking", 0), 0u) << flights.front().name;
}

/// Only what accelerates the mass itself tells a load from a pull: thrust that is not known to the size of
/// the load, together with a force of the world, imitates that.
TEST(Propose, HeavingTellsALoadFromAPullAndClimbingDoesNot) {
  const vehicle::Vehicle v = test::omnimorph();
  const physics::ActiveEffect load{physics::find_effect("payload_mass"), {0.02}},
      pull{physics::find_effect("constant_pull"), {0, 0, -0.02 * 9.81}};
  Options o;
  o.tolerance.thrust_scale = 0.002;
  o.tolerance.air_density = 0;
  const auto flights = proposed(v, load, {load, pull}, o);
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
  const physics::ActiveEffect weak{physics::find_effect("thrust_scale"), {-0.05}},
      by_tilt{physics::find_effect("tilt_efficiency"), {0.05, 0.0}};
  const auto flights = proposed(v, weak, {weak, by_tilt});
  const ProposedFlight *still = find(flights, "rocking_at_three_heights"),
                       *moving = find(flights, "rocking_and_tilting");
  ASSERT_TRUE(still && moving);
  printf("weak thrust against one that changes with the tilt: one tilt %.2f sigma, three %.2f sigma\n",
         still->separation_sigma, moving->separation_sigma);
  EXPECT_LT(still->separation_sigma, 1);
  EXPECT_GT(moving->separation_sigma, 5);
}

TEST(Propose, WhatAFlightWouldHardlyTellApartIsSaid) {
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
