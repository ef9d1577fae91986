// The families: what is hidden in how many ways, boxes that never meet, sizes that are what they say, files
// that load.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "family_aliases.hpp"
#include "family_laboratory.hpp"
#include "family_make.hpp"
#include "omniflight_proof/plant.hpp"
#include "omniflight_recording/formats.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;

TEST(Hidden, EveryIdOfTheCatalogueHasTwoRealisationsOneOfThemNotItsLaw) {
  std::map<std::string, int> ways, others;
  for (const Hidden& h : hidden_effects()) {
    ++ways[h.id];
    others[h.id] += !h.law;
    EXPECT_TRUE(h.apply) << h.id;
    EXPECT_EQ(h.measure == Hidden::Measure::formula, static_cast<bool>(h.size)) << h.realisation;
    EXPECT_LT(0, h.smallest) << h.realisation;
    EXPECT_LT(h.smallest, h.typical) << h.realisation;
    EXPECT_LT(h.typical, h.largest) << h.realisation;
    EXPECT_EQ(h.id == "unknown", !h.variables.empty()) << h.realisation;
  }
  EXPECT_EQ(catalogue().size(), 58u);
  for (const std::string& id : catalogue()) {
    EXPECT_GE(ways[id], 2) << id;
    EXPECT_GE(others[id], 1) << id;
  }
  EXPECT_EQ(ways.size(), catalogue().size() + 1) << "an id that is in no contract";
}

TEST(Boxes, TuningAndSealedNumbersNeverMeet) {
  BoxRandom tuning(Random(3), Box::tuning), sealed(Random(3), Box::sealed);
  for (int k = 0; k < 20000; ++k) {
    const double t = tuning.unit(), s = sealed.unit();
    ASSERT_TRUE(t >= 0 && t < 1 && s >= 0 && s < 1);
    EXPECT_EQ(static_cast<int>(8 * t) % 2, 0);
    EXPECT_EQ(static_cast<int>(8 * s) % 2, 1);
  }
}

FamilyDrawOptions options(Box box, int cases, int nulls) {
  FamilyDrawOptions o;
  o.salt = "a salt of the tests";
  o.box = box;
  o.cases = cases;
  o.nulls = nulls;
  return o;
}

TEST(Draw, TuningDrawsNothingUnseenAndASealedRunDoes) {
  auto tuning = draw_families(options(Box::tuning, 150, 100));
  ASSERT_TRUE(tuning) << tuning.error().text();
  for (const FamilyPlan& p : *tuning) EXPECT_TRUE(p.unseen.empty()) << p.id << ' ' << p.unseen.front();
  auto sealed = draw_families(options(Box::sealed, 150, 100));
  ASSERT_TRUE(sealed) << sealed.error().text();
  std::set<std::string> unseen;
  for (const FamilyPlan& p : *sealed) unseen.insert(p.unseen.begin(), p.unseen.end());
  EXPECT_EQ(unseen, (std::set<std::string>{"controller", "manoeuvre", "mechanism", "turbulence", "vehicle"}));
}

TEST(Draw, HidesEveryIdBeforeAnyAgainAndRepeatsForItsSalt) {
  auto plans = draw_families(options(Box::tuning, 160, 40));
  ASSERT_TRUE(plans) << plans.error().text();
  ASSERT_EQ(plans->size(), 200u);
  std::set<std::string> ids, vehicles, flights;
  int pairs = 0, triples = 0, unknown = 0, nominal = 0;
  for (const FamilyPlan& p : *plans) {
    for (const std::size_t h : p.hidden) ids.insert(hidden_effects()[h].id);
    vehicles.insert(p.where.vehicle);
    flights.insert(p.where.manoeuvre);
    pairs += p.kind == Kind::pair;
    triples += p.kind == Kind::triple;
    unknown += p.kind == Kind::unknown;
    nominal += p.hidden.empty();
    for (const std::size_t h : p.hidden)
      if (hidden_effects()[h].slow) {
        EXPECT_LE(p.where.length, 75);
      }
  }
  for (const std::string& id : catalogue()) EXPECT_TRUE(ids.count(id)) << id;
  EXPECT_EQ(vehicles.size(), std::size(kFamilyVehicles));
  EXPECT_EQ(flights.size(), 6u);
  EXPECT_EQ(nominal, 40);
  EXPECT_GT(pairs, 10);
  EXPECT_GT(triples, 5);
  EXPECT_GT(unknown, 10);
  auto again = draw_families(options(Box::tuning, 160, 40));
  ASSERT_TRUE(again);
  for (std::size_t k = 0; k < plans->size(); ++k) {
    EXPECT_EQ((*plans)[k].hidden, (*again)[k].hidden);
    EXPECT_EQ((*plans)[k].where.length, (*again)[k].where.length);
  }
}

TEST(Draw, RefusesEffectsThatNobodyHas) {
  auto o = options(Box::tuning, 3, 0);
  o.effects = {"no_such_effect"};
  auto plans = draw_families(o);
  ASSERT_FALSE(plans);
  EXPECT_NE(plans.error().text().find("--effects"), std::string::npos) << plans.error().text();
}

FamilyPlan plan(const std::string& vehicle, const std::string& effect, bool law, double sigma) {
  FamilyPlan p;
  p.id = "case-0001";
  p.where = {.vehicle = vehicle,
             .controller = "geometric",
             .told_gains = "told",
             .start = "in flight",
             .manoeuvre = "eight",
             .signals = "imu+speed",
             .reference = true,
             .turbulence = "heavy",
             .noise = "white",
             .calibration = "told",
             .length = 12,
             .tilt = "none"};
  p.where.tilt = vehicle == "omnimorph" ? "fixed" : "none";
  p.where.alpha_deg = vehicle == "omnimorph" ? 30 : 0;
  p.sigma = sigma;
  for (std::size_t k = 0; k < hidden_effects().size() && !effect.empty(); ++k)
    if (hidden_effects()[k].id == effect && hidden_effects()[k].law == law) p.hidden = {k};
  p.kind = effect.empty() ? Kind::null : Kind::single;
  return p;
}

/// A case whose files have been written to a folder and loaded again.
struct Loaded {
  FamilyCase truth;
  recording::Recording recording;
  vehicle::Vehicle vehicle;
};
void load(const FamilyPlan& p, Loaded& out) {
  auto made = make_family_case(p, "a salt of the tests", Box::tuning, {});
  ASSERT_TRUE(made) << made.error().text();
  out.truth = made->truth;
  const fs::path folder = fs::temp_directory_path() / ("families-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const auto write = [&](const char* name, const std::string& content) {
    std::ofstream(folder / name, std::ios::binary) << content;
    return folder / name;
  };
  auto recording = recording::load(write("flight.csv.gz", made->recording));
  auto vehicle = vehicle::load_vehicle(write("vehicle.yaml", made->vehicle).string());
  fs::remove_all(folder);
  ASSERT_TRUE(recording) << recording.error().text();
  ASSERT_TRUE(vehicle) << vehicle.error().text();
  out.recording = *recording;
  out.vehicle = *vehicle;
}

TEST(Make, AnEffectHasTheSizeThatItsTruthSays) {
  Loaded c;
  load(plan("quadrotor_37g", "constant_pull", true, 3), c);
  if (HasFatalFailure()) return;
  ASSERT_EQ(c.truth.sizes.size(), 1u);
  EXPECT_NEAR(c.truth.sizes[0].sigma, 3, 0.3);
  EXPECT_GT(c.truth.oracle.detect, kSeparable)
      << "three times the noise for twelve seconds is seen by an oracle";
  // of the recording itself: mean specific force less mean thrust is the pull
  const auto *acc = c.recording.find("acc"), *speed = c.recording.find("rotor_speed"),
             *q = c.recording.find("attitude");
  ASSERT_TRUE(acc && speed && q);
  EXPECT_NEAR(c.recording.duration_s, 12, 0.1);
  const auto at = recording::resample(*acc, q->t_s), turning = recording::resample(*speed, q->t_s);
  Vec3 sum = Vec3::Zero();
  int n = 0;
  for (Eigen::Index i = 0; i < q->size(); ++i) {
    if (!at.row(i).allFinite() || !turning.row(i).allFinite()) continue;
    Vec3 force = c.vehicle.mass * at.row(i).transpose();
    for (int k = 0; k < c.vehicle.rotor_count(); ++k)
      force -= c.vehicle.rotors[static_cast<std::size_t>(k)].thrust(turning(i, k)) * Vec3::UnitZ();
    const Quat attitude(q->values(i, 0), q->values(i, 1), q->values(i, 2), q->values(i, 3));
    sum += attitude * force;
    ++n;
  }
  ASSERT_GT(n, 500);
  Vec3 pull;
  for (int k = 0; k < 3; ++k)
    pull[k] = c.truth.truth.effects[0].parameters.at(static_cast<std::size_t>(k)).value;
  EXPECT_LT((sum / n - pull).norm(), 0.35 * pull.norm())
      << (sum / n).transpose() << " for " << pull.transpose();
}

TEST(Make, EveryVehicleFliesWithEveryController) {
  for (const char* vehicle :
       {"quadrotor_37g", "quadrotor_1200g", "hexarotor", "hexarotor_tilted", "omnimorph", "octorotor"})
    for (const char* controller : {"geometric", "cascade", "indi", "sliding"}) {
      FamilyPlan p = plan(vehicle, "", true, 0);
      p.where.controller = controller;
      p.where.length = 5;
      BoxRandom random(Random(11), Box::tuning);
      auto v = draw_vehicle(p.where, random);
      ASSERT_TRUE(v) << v.error().text();
      Laboratory lab = draw_laboratory(p.where, *v, "", 1, random);
      lab.flight.record = false;
      auto flown = fly(lab.flight);
      ASSERT_TRUE(flown) << vehicle << ' ' << controller << ": " << flown.error().text();
      EXPECT_LT(flown->tracking, 0.25 * v->reach) << vehicle << ' ' << controller;
    }
}

TEST(Make, TwoRealisationsOfOneEffectAreTheSameSize) {
  for (const bool law : {true, false}) {
    auto made = make_family_case(plan("quadrotor_1200g", "rotor_drag", law, 1), "a salt of the tests",
                                 Box::tuning, {});
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_NEAR(made->truth.sizes.at(0).sigma, 1, 0.15) << made->truth.truth.effects[0].realisation;
    EXPECT_EQ(made->truth.sizes[0].law, law);
  }
}

TEST(Turbulence, EveryKindHasTheStrengthThatIsAsked) {
  Coordinates where = plan("quadrotor_1200g", "", true, 0).where;
  BoxRandom random(Random(5), Box::tuning);
  auto v = draw_vehicle(where, random);
  ASSERT_TRUE(v);
  for (const auto kind :
       {Turbulence::Kind::ou, Turbulence::Kind::dryden, Turbulence::Kind::heavy, Turbulence::Kind::bursts}) {
    World world;
    world.turbulence =
        Turbulence{.kind = kind, .force_rms = 0.2, .torque_rms = 0.01, .correlation_time = 0.01};
    auto plant = MujocoPlant::create(v->nominal, world, {.step = 0.001, .initial = {}});
    ASSERT_TRUE(plant) << plant.error().text();
    const std::vector<double> still(4, 0.0);
    plant->set_command(still, 0);
    double force = 0, torque = 0;
    int n = 0;
    for (int k = 0; k < 6000; ++k) {  // falls freely
      ASSERT_TRUE(plant->step());
      const Vec6 w = plant->unmodelled_wrench();
      force += w.head<3>().squaredNorm() / 3;
      torque += w.tail<3>().squaredNorm() / 3;
      ++n;
    }
    EXPECT_NEAR(std::sqrt(force / n), 0.2, 0.04) << static_cast<int>(kind);
    EXPECT_NEAR(std::sqrt(torque / n), 0.01, 0.002) << static_cast<int>(kind);
  }
}

TEST(Aliases, MergeOnlyWhatTheFlightCannotTellApart) {
  Coordinates c = plan("quadrotor_1200g", "", true, 0).where;
  EXPECT_EQ(family_names("thrust_scale", c), "payload_mass");
  EXPECT_EQ(family_names("wind", c), "wind");
  EXPECT_EQ(family_names("cable_chain", c), "hung_cable");
  c.signals = "command";
  EXPECT_EQ(family_names("wind", c), "mocap_tilt");
  EXPECT_TRUE(stage_is_right("motor_lag", "actuation", "wrench", c));
  c.manoeuvre = "T1";
  EXPECT_EQ(family_names("cable_chain", c), "payload_mass");
}

}  // namespace
}  // namespace omniflight::proof
