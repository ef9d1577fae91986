// Certified plans of random missions, flown with gusts and with the cable that hangs from the vehicle:
// nothing is hit, the rotors keep headroom, and the tether keeps its limits. OMNIFLIGHT_REPETITIONS sets how
// many plans.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "../src/mission_loads.hpp"
#include "omniflight_campaign/many_flights.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/plan.hpp"

using namespace omniflight;
using namespace omniflight::cli;

namespace {

constexpr int kSeeds = 8;     // flights of a plan, each with its gusts
constexpr int kTries = 4000;  // missions that are drawn at most for a plan

/// A mission between random poses of the test bed, with a tether from the counter and gusts in its margin.
planning::Mission random_mission(Random& random, const planning::DistanceMap& map,
                                 const vehicle::Vehicle& vehicle) {
  planning::Mission m;
  m.name = "random";
  m.alpha = to_radians(45);
  m.budget_s = 2.0;
  m.clearance = 0.03;
  m.limits.rotor_headroom = 0.15;
  m.tracking_position = 0.02;
  m.tracking_attitude = to_radians(4.0);
  m.tracking_in_margin = true;
  m.tether = planning::Tether{.anchor_W = Vec3(0, 0, 0.62), .length = 4.0, .linear_mass = 0.05};
  m.tether->cone = to_radians(80);
  m.tether->twist = to_radians(200);
  // What the law, a spring of mass times gain, does not know: gusts of 0.3 N (3.1 m/s, four times their
  // intensity), and two metres of the tether.
  const double unknown = 0.3 + 2.0 * m.tether->linear_mass * kGravity;
  m.gust = planning::Gust{.force = unknown,
                          .compliance = 1.0 / (vehicle.mass * control::LawConfig{}.gains.kp.minCoeff())};
  for (const char* name : {"start", "via", "goal"}) {
    planning::Waypoint w;
    w.name = name;
    do
      for (int k = 0; k < 3; ++k) w.pose.p_WB[k] = random.uniform(map.lower()[k], map.upper()[k]);
    while (map.distance(w.pose.p_WB) < 0.4);
    w.pose.q_WB = from_roll_pitch_yaw(
        Vec3(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-1.2, 1.2)));
    m.waypoints.push_back(w);
  }
  return m;
}

campaign::Loop loop_of(const planning::Plan& plan, const vehicle::Vehicle& vehicle) {
  campaign::Loop loop;
  loop.vehicle = loop.believed = vehicle;
  loop.allocator = allocation::AllocatorConfig::case_a();
  loop.allocator.tilt_mode = allocation::TiltMode::fixed;
  loop.allocator.initial_tilt = loop.plant.initial_alpha = plan.certificate.alpha;
  loop.trajectory = plan.trajectory;
  loop.duration = loop.hold + loop.settle + plan.trajectory.duration() + 1.0;
  const Reference& start = plan.trajectory.knots().front().reference;
  loop.plant.initial.p_WB = start.p_WB;
  loop.plant.initial.q_WB = start.q_WB;
  return loop;
}

TEST(CertifiedFlights, RandomPlansKeepClearOfEverythingWithGustsAndTheHungCable) {
  const char* asked = std::getenv("OMNIFLIGHT_REPETITIONS");
  const int wanted = asked ? std::atoi(asked) : 10;
  const std::string configs = OMNIFLIGHT_SOURCE_ROOT "/configs/";
  const auto vehicle = vehicle::load_vehicle(configs + "vehicles/omnimorph/omnimorph.yaml").value();
  const auto map = planning::DistanceMap::load(configs + "test_beds/pyramid.bt").value();
  Random random(32, "certified flights");
  int plans = 0, drawn = 0, flights = 0, ended = 0, outside = 0, saturated = 0;
  double worst_position = 0, worst_attitude = 0, least_headroom = 1, least_clearance = 1, way = 0, time = 0;
  for (; plans < wanted && drawn < kTries * wanted; ++drawn) {
    const planning::Mission mission = random_mission(random, map, vehicle);
    planning::PlanOptions options;
    options.seed = static_cast<std::uint64_t>(drawn);
    const auto plan = planning::plan(mission, vehicle, map, options);
    if (!plan) continue;  // most draws put a waypoint into something
    ++plans;
    const auto& knots = plan->trajectory.knots();
    const auto loads = effects_of_loads(mission, vehicle, knots);
    ASSERT_TRUE(loads) << loads.error().text();
    std::vector<campaign::OneFlight> each(kSeeds);
    campaign::Loop loop = loop_of(*plan, vehicle);
    for (int k = 0; k < kSeeds; ++k) {
      campaign::OneFlight& one = each[static_cast<std::size_t>(k)];
      one.model.effects = *loads;
      one.model.effects.push_back({physics::find_effect("gust"), {0.8, 1.0, 0.05}});
      one.start = loop.plant.initial;
      one.seed = static_cast<std::uint64_t>(kSeeds * drawn + k);
    }
    const auto flown = campaign::fly_many(loop, each);
    ASSERT_TRUE(flown) << flown.error().text();
    // Within the tube of the margin the certificate itself keeps vehicle and tether from everything.
    const planning::Tube& tube = plan->certificate.tube;
    for (const campaign::FlightFigures& f : *flown) {
      ++flights;
      ended += f.ended_early.has_value();
      outside += f.worst_position > tube.position || f.worst_attitude > tube.attitude;
      saturated += f.least_headroom <= 0.0 || f.share_at_limit > 0.0;
      worst_position = std::max(worst_position, f.worst_position);
      worst_attitude = std::max(worst_attitude, f.worst_attitude);
      least_headroom = std::min(least_headroom, f.least_headroom);
    }
    time += kSeeds * loop.duration;
    least_clearance = std::min(least_clearance, plan->certificate.min_clearance);
    for (std::size_t k = 1; k < knots.size(); ++k)
      way += (knots[k].reference.p_WB - knots[k - 1].reference.p_WB).norm();
  }
  const planning::Tube tube = planning::tube_for(random_mission(random, map, vehicle), vehicle, {}).value();
  std::printf("%d plans of %d missions drawn, %.1f m, %d flights, %.0f s\n", plans, drawn, way, flights,
              time);
  std::printf("  ended early              %d\n", ended);
  std::printf("  left the tube            %d  worst %.1f of %.1f mm, %.2f of %.2f deg\n", outside,
              1e3 * worst_position, 1e3 * tube.position, to_degrees(worst_attitude),
              to_degrees(tube.attitude));
  std::printf("  rotors at their limits   %d  least headroom %.3f\n", saturated, least_headroom);
  std::printf("  least clearance planned  %.3f m\n", least_clearance);
  ASSERT_EQ(plans, wanted);
  EXPECT_EQ(ended, 0);
  EXPECT_EQ(outside, 0);
  EXPECT_EQ(saturated, 0);
}

}  // namespace
