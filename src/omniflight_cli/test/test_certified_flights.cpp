// Certified plans of random missions, flown with gusts and with the cable that hangs from the vehicle: on the
// flown path nothing is hit, no rotor is at an end of its range, and the tether keeps its limits.
// OMNIFLIGHT_REPETITIONS sets how many plans, OMNIFLIGHT_SEED another seed.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "../src/mission_loads.hpp"
#include "certified_missions.hpp"
#include "omniflight_planning/flown.hpp"

using namespace omniflight;
using namespace omniflight::certified;

namespace {

constexpr int kSeeds = 8;          // flights of a plan, each with its gusts
constexpr int kTries = 4000;       // missions that are drawn at most for a plan
constexpr int kPlansOfARoom = 10;  // after which another one is made
constexpr auto kShortest = planning::Timing::shortest;

const Kind kKinds[] = {
    {.name = "omnimorph tethered", .vehicle = "omnimorph", .tethered = true},
    {.name = "omnimorph tethered, shortest", .vehicle = "omnimorph", .tethered = true, .timing = kShortest},
    {.name = "omnimorph shortest", .vehicle = "omnimorph", .timing = kShortest},
    {.name = "omnimorph tilting", .vehicle = "omnimorph", .tethered = true, .tilting = true},
    {.name = "omnimorph tilting in flight",
     .vehicle = "omnimorph",
     .tethered = true,
     .tilting = true,
     .in_flight = true},
    {.name = "omnimorph tilting in flight, shortest",
     .vehicle = "omnimorph",
     .tethered = true,
     .tilting = true,
     .in_flight = true,
     .timing = kShortest},
    {.name = "quadrotor",
     .vehicle = "quadrotor_1200g",
     .leans = true,
     .tracking_position = 0.03,
     .tracking_attitude = to_radians(8.0)},
    {.name = "omnicopter shortest", .vehicle = "omnicopter", .timing = kShortest},
};

/// What is left of a rotor's range, the least of all rotors: 1 in the middle, 0 at an end, as certificates
/// count.
double headroom_of(const vehicle::RotorVector& u, const vehicle::Vehicle& vehicle) {
  const vehicle::RotorVector low = vehicle.lower_thrusts(), high = vehicle.upper_thrusts();
  return 2.0 * ((u - low).cwiseMin(high - u).array() / (high - low).array()).minCoeff();
}

/// Way [m] that no vehicle point exceeds between two looks; half of it a path may be nearer in between.
double longest_step(const std::vector<planning::FlownPose>& path, double radius) {
  double out = 0;
  for (std::size_t k = 1; k < path.size(); ++k)
    out = std::max(out, (path[k].pose.p_WB - path[k - 1].pose.p_WB).norm() +
                            radius * path[k].pose.q_WB.angularDistance(path[k - 1].pose.q_WB));
  return out;
}

/// Flies a plan kSeeds times and adds what came of it.
void fly(const Kind& kind, const planning::Mission& mission, const planning::Plan& plan,
         const vehicle::Vehicle& vehicle, planning::FlownCheck& check, std::uint64_t number, Score& score) {
  const auto& knots = plan.trajectory.knots();
  const auto loads = cli::effects_of_loads(mission, vehicle, knots);
  ASSERT_TRUE(loads) << loads.error().text();
  std::vector<campaign::OneFlight> each(kSeeds);
  std::vector<std::vector<planning::FlownPose>> paths(kSeeds);
  std::vector<double> headroom(kSeeds, 1.0);
  campaign::Loop loop = loop_of(plan, vehicle);
  loop.watch = [&](const campaign::FlightMoment& m) {
    paths[m.flight].push_back({m.along, {m.state.p_WB, m.state.q_WB}, m.alpha});
    headroom[m.flight] = std::min(headroom[m.flight], headroom_of(m.u, vehicle));
  };
  for (int k = 0; k < kSeeds; ++k) {
    campaign::OneFlight& one = each[static_cast<std::size_t>(k)];
    one.model.effects = *loads;
    one.model.effects.push_back({physics::find_effect("gust"), {kIntensity, kCorrelation, kArea}});
    one.start = loop.plant.initial;
    one.law = law_of(plan, vehicle);
    one.seed = kSeeds * number + static_cast<std::uint64_t>(k);
  }
  const auto flown = campaign::fly_many(loop, each);
  ASSERT_TRUE(flown) << flown.error().text();
  const planning::Tube& tube = plan.certificate.tube;
  const double radius = planning::cover_with_spheres(vehicle, plan.certificate.alpha).bounding_radius;
  for (std::size_t k = 0; k < flown->size(); ++k) {
    const campaign::FlightFigures& f = (*flown)[k];
    const std::string where = std::string(kind.name) + ", mission " + std::to_string(number) + ", flight " +
                              std::to_string(k) + ": ";
    ++score.flights;
    if (f.ended_early) ++score.ended, score.fault(where + "ended early");
    if (f.worst_position > tube.position || f.worst_attitude > tube.attitude)
      ++score.outside, score.fault(where + "left the tube");
    if (headroom[k] <= 0.0) ++score.saturated, score.fault(where + "a rotor is at an end of its range");
    const planning::FlownClearance near = check.clearance(paths[k], vehicle);
    const double clearance = near.least - 0.5 * longest_step(paths[k], radius);
    if (clearance <= 0.0) ++score.hit, score.fault(where + "hit at " + std::to_string(near.at) + " s");
    if (mission.tether)
      if (const auto why = check.tether(paths[k], *mission.tether).violation(*mission.tether))
        ++score.tether, score.fault(where + *why);
    score.least_clearance = std::min(score.least_clearance, clearance);
    score.least_headroom = std::min(score.least_headroom, headroom[k]);
    score.worst_position = std::max(score.worst_position, f.worst_position / tube.position);
    score.worst_attitude = std::max(score.worst_attitude, f.worst_attitude / tube.attitude);
  }
  ++score.plans;
  score.time += kSeeds * plan.trajectory.duration();
  score.planned_clearance = std::min(score.planned_clearance, plan.certificate.min_clearance);
  score.planned_headroom = std::min(score.planned_headroom, 1.0 - plan.certificate.peak.rotor_load);
  for (std::size_t k = 1; k < knots.size(); ++k)
    score.way += (knots[k].reference.p_WB - knots[k - 1].reference.p_WB).norm();
}

void print(const char* name, const Score& s) {
  std::printf(
      "%-37s %4d of %6d missions, %6.1f m, %5d flights, %7.0f s; ended %d, hit %d, saturated %d, "
      "tether %d, outside the tube %d\n",
      name, s.plans, s.drawn, s.way, s.flights, s.time, s.ended, s.hit, s.saturated, s.tether, s.outside);
  std::printf(
      "%-37s flown: clearance %.3f m, headroom %.3f; planned: %.3f m, %.3f; of the tube: position "
      "%.2f, attitude %.2f\n",
      "", s.least_clearance, s.least_headroom, s.planned_clearance, s.planned_headroom, s.worst_position,
      s.worst_attitude);
}

TEST(CertifiedFlights, RandomPlansKeepClearOfEverythingWithGustsAndTheHungCable) {
  const char *asked = std::getenv("OMNIFLIGHT_REPETITIONS"), *other = std::getenv("OMNIFLIGHT_SEED");
  const int wanted = asked ? std::atoi(asked) : 24;
  const auto seed = static_cast<std::uint64_t>(other ? std::atoll(other) : 32);
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  const std::string configs = OMNIFLIGHT_SOURCE_ROOT "/configs/";
  Random random(seed, "certified flights");
  const auto bed = load_room(configs + "test_beds/pyramid.bt");
  ASSERT_TRUE(bed) << bed.error().text();
  std::vector<vehicle::Vehicle> vehicles;
  for (const Kind& kind : kKinds)
    vehicles.push_back(
        vehicle::load_vehicle(configs + "vehicles/" + kind.vehicle + "/" + kind.vehicle + ".yaml").value());
  std::vector<Score> scores(std::size(kKinds));
  int plans = 0;
  std::uint64_t drawn = 0;
  for (int rooms = 0; plans < wanted && drawn < static_cast<std::uint64_t>(kTries * wanted); ++rooms) {
    Result<Room> made = Room{bed->file, bed->map};
    if (rooms % 2 == 1)
      made = random_room(random, std::filesystem::path(testing::TempDir()) / "certified_flights.bt");
    ASSERT_TRUE(made) << made.error().text();
    auto check = planning::FlownCheck::load(made->file);
    ASSERT_TRUE(check) << check.error().text();
    for (int left = kPlansOfARoom, tries = kTries; left > 0 && tries > 0 && plans < wanted;
         --tries, ++drawn) {
      const std::size_t k = static_cast<std::size_t>(plans) % std::size(kKinds);
      const planning::Mission mission = random_mission(random, kKinds[k], made->map, vehicles[k]);
      planning::PlanOptions options;
      options.seed = drawn;
      ++scores[k].drawn;
      const auto plan = planning::plan(mission, vehicles[k], made->map, options);
      if (!plan) continue;  // most draws put a waypoint into something
      if (!cli::effects_of_loads(mission, vehicles[k], plan->trajectory.knots()))
        continue;  // below the anchor
      fly(kKinds[k], mission, *plan, vehicles[k], *check, drawn, scores[k]);
      ++plans, --left;
    }
  }
  for (std::size_t k = 0; k < scores.size(); ++k) {
    const Score& s = scores[k];
    print(kKinds[k].name, s);
    EXPECT_EQ(s.ended + s.hit + s.outside + s.saturated + s.tether, 0) << s.first_fault;
  }
  EXPECT_EQ(plans, wanted);
}

}  // namespace
