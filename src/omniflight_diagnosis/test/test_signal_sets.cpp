// Recordings that lack signals: what can still be said is said, and what cannot is named.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "../src/search/offered_effects.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_recording/formats.hpp"
#include "real_data.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::flights;

vehicle::Vehicle load(const char* name) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle(name);
  EXPECT_TRUE(v) << v.error().text();
  return *v;
}

/// One, or all with OMNIFLIGHT_LONG: each takes seconds.
std::uint64_t flights_asked(std::uint64_t all) { return std::getenv("OMNIFLIGHT_LONG") ? all : 1; }

Options two_threads() {
  Options o;
  o.threads = 2;
  o.rollouts = false;
  return o;
}

TEST(SignalSets, DutyCyclesAloneCarryAWrenchAnalysisWithoutAFalseMass) {
  const vehicle::Vehicle v = load("omnimorph");
  test::Flown flown;
  flown.duration_s = 20;
  recording::Recording r = test::fly(v, {}, flown);
  test::drive_by_duty(r, v, 0.7);
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(d->verdict, Verdict::nothing_missing) << d->summary;
  EXPECT_NE(d->summary.find("duty cycle"), std::string::npos) << d->summary;
}

/// Inertia times twice differentiated noise of a pose looks like a spring to the very noise.
TEST(SignalSets, APoseThatIsDifferentiatedHasNoSpringInItsNoise) {
  const vehicle::Vehicle v = load("omnimorph");
  for (std::uint64_t seed = 1; seed <= flights_asked(3); ++seed) {
    test::Flown f;
    f.duration_s = 12, f.sway = 0.25, f.seed = seed;
    f.force_noise_N = 0.01, f.torque_noise_Nm = 0.0005;  // calm air: the pose's noise is what is left
    const recording::Recording flown = test::fly(v, {}, f);
    for (const std::vector<const char*>& missing : std::vector<std::vector<const char*>>{
             {"gyro"}, {"gyro", "acc"}, {"gyro", "acc", "velocity"}, {"acc", "velocity"}}) {
      recording::Recording r = flown;
      Random random(seed, "pose");
      auto& p = r.signals["position"].values;
      auto& q = r.signals["attitude"].values;
      for (Eigen::Index i = 0; i < p.size(); ++i) p.data()[i] += 2e-4 * random.normal();
      for (Eigen::Index i = 0; i < q.size(); ++i) q.data()[i] += 5e-4 * random.normal();
      for (const char* name : missing) r.signals.erase(name);
      const auto d = diagnose(std::span(&r, 1), {}, v, two_threads());
      ASSERT_TRUE(d) << d.error().text();
      EXPECT_TRUE(d->findings.empty()) << "seed " << seed << " without " << missing.front() << ", "
                                       << missing.size() << " signals: " << d->summary;
    }
  }
}

/// Less thrust for the same speed takes the noise of the speeds out of the residual.
TEST(SignalSets, RotorSpeedsWithNoiseAreNotRotorsThatAreTooWeak) {
  const vehicle::Vehicle v = load("crazyflie_brushless");
  for (std::uint64_t seed = 1; seed <= flights_asked(4); ++seed) {
    test::Flown f;
    f.duration_s = 12, f.sway = 0.25, f.seed = seed;
    f.force_noise_N = 1e-4, f.torque_noise_Nm = 2e-7;
    recording::Recording r = test::fly(v, {}, f);
    Random random(seed, "telemetry");
    auto& p = r.signals["position"].values;
    auto& s = r.signals["rotor_speed"].values;
    for (Eigen::Index i = 0; i < p.size(); ++i) p.data()[i] += 1e-4 * random.normal();
    for (Eigen::Index i = 0; i < s.size(); ++i) s.data()[i] += 8 * random.normal();
    for (const char* name : {"acc", "velocity"}) r.signals.erase(name);
    const auto d = diagnose(std::span(&r, 1), {}, v, two_threads());
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_TRUE(d->findings.empty()) << "seed " << seed << ": " << d->summary;
  }
}

TEST(SignalSets, WhatOnlyTorquesTellIsNotOfferedWithoutThem) {
  const vehicle::Vehicle v = load("omnimorph");
  test::Flown flown;
  flown.duration_s = 12;
  recording::Recording r = test::fly(v, {}, flown);
  const auto offered = [&](const char* id) {
    const auto f = prepare_flight(r, v, {});
    EXPECT_TRUE(f) << f.error().text();
    const Flight* one[] = {&*f};
    const auto all = offered_effects(one, v, {});
    return std::any_of(all.begin(), all.end(), [&](const auto* e) { return e->info().id == id; });
  };
  EXPECT_TRUE(offered("rotor_axis_misalignment"));
  EXPECT_TRUE(offered("com_offset"));
  EXPECT_TRUE(offered("rotor_drag"));
  test::drive_by_duty(r, v, 0.7);
  EXPECT_FALSE(offered("rotor_axis_misalignment"));
  EXPECT_FALSE(offered("com_offset"));
  EXPECT_TRUE(offered("rotor_drag"));
}

TEST(SignalSets, ASpecificForceInWorldAxesIsTurnedIntoTheBody) {
  const vehicle::Vehicle v = load("crazyflie_brushless");  // leans to move sideways
  recording::Recording r;
  for (const auto& [name, width] :
       {std::pair{"attitude", 4}, {"velocity", 3}, {"acc", 3}, {"gyro", 3}, {"rotor_speed", 4}}) {
    recording::Signal& s = r.signals[name];
    s.name = name;
    s.values.resize(600, width);
    for (int i = 0; i < 600; ++i) s.t_s.push_back(0.01 * i);
  }
  r.duration_s = 6;
  const double hover = std::sqrt(v.mass * 9.81 / 4 / v.rotors[0].thrust_coefficient);
  for (int i = 0; i < 600; ++i) {
    const double t = 0.01 * i, lean = 0.1 * std::sin(2 * t), rate = 0.2 * std::cos(2 * t);
    r.signals["attitude"].values.row(i) << std::cos(lean / 2), 0, std::sin(lean / 2), 0;
    r.signals["velocity"].values.row(i) << -9.81 * 0.05 * std::cos(2 * t), 0, 0;
    r.signals["acc"].values.row(i) << 0, 0, 9.81 / std::cos(lean);
    r.signals["gyro"].values.row(i) << 0, rate, 0;
    r.signals["rotor_speed"].values.row(i).setConstant(hover / std::sqrt(std::cos(lean)));
  }
  const auto in_body = prepare_flight(r, v, {});
  ASSERT_TRUE(in_body) << in_body.error().text();
  for (int i = 0; i < 600; ++i) {
    const double lean = 0.1 * std::sin(0.02 * i);
    r.signals["acc"].values.row(i) << 9.81 * std::tan(lean), 0, 9.81;
  }
  const auto in_world = prepare_flight(r, v, {});
  ASSERT_TRUE(in_world) << in_world.error().text();
  const auto turned = [](const Flight& f) {
    return std::any_of(f.notes.begin(), f.notes.end(),
                       [](const std::string& n) { return n.find("world's axes") != std::string::npos; });
  };
  EXPECT_FALSE(turned(*in_body));
  EXPECT_TRUE(turned(*in_world));
  EXPECT_LT((in_world->specific_force - in_body->specific_force).cwiseAbs().maxCoeff(), 0.02);
}

TEST(SignalSets, EveryRecordingBringsItsOwnNeighbours) {
  const vehicle::Vehicle v = load("omnimorph");
  test::Flown flown;
  flown.duration_s = 12;
  recording::Recording r = test::fly(v, {}, flown);
  Options o;
  o.neighbours.push_back({{0.0}, {Vec3(1, 0, 1)}});
  recording::Signal& track = r.signals["neighbour1_position"];
  track.name = "neighbour1_position";
  track.t_s = {0, 12};
  track.values.resize(2, 3);
  track.values << 0, 0, 2, 0, 0, 3;
  const auto f = prepare_flight(r, v, o);
  ASSERT_TRUE(f) << f.error().text();
  const physics::Situation& s = f->situation[f->situation.size() / 2];
  ASSERT_EQ(s.neighbour_count, 2);
  EXPECT_NEAR(s.all_neighbours()[1].p_WN.z(), 2 + s.t / 12, 1e-6);
  track.t_s = {12, 0};  // no track
  const auto without = prepare_flight(r, v, o);
  ASSERT_TRUE(without) << without.error().text();
  EXPECT_EQ(without->situation[0].neighbour_count, 1);
}

/// A force that no function of the state makes is not given the name of one.
TEST(SignalSets, AForceThatComesAndGoesOnceHasNoName) {
  const vehicle::Vehicle v = load("omnimorph");
  test::Flown flown;
  flown.duration_s = 24;
  flown.force_noise_N = 0.05;
  recording::Recording r = test::fly(v, {}, flown);
  Eigen::MatrixXd& acc = r.signals["acc"].values;
  for (Eigen::Index i = 0; i < acc.rows(); ++i) {
    const double t = r.signals["acc"].t_s[static_cast<std::size_t>(i)];
    if (t > 10.0 && t < 11.5) acc(i, 2) -= 1.2 / v.mass * std::sin(kPi * (t - 10.0) / 1.5);
  }
  const auto d = diagnose(std::span(&r, 1), {}, v, two_threads());
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_TRUE(d->findings.empty()) << d->summary;
}

/// The recordings of a folder of the damaged-propeller set, by name.
std::vector<recording::Recording> all_in(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(flights() / "crazyflie_damaged_propeller" / folder))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<recording::Recording> out;
  for (const auto& file : files) {
    auto r = recording::load(file);
    EXPECT_TRUE(r) << r.error().text();
    if (r) out.push_back(std::move(*r));
  }
  return out;
}

/// Names found in the single flights of a folder of the damaged-propeller set.
struct Answers {
  int flights = 0, rotor3 = 0, other_rotor = 0, any = 0;
  double mean_scale = 0;
};

Answers answers(const std::string& folder) {
  Answers a;
  const vehicle::Vehicle v = load("crazyflie_brushed");
  for (const recording::Recording& r : all_in(folder)) {
    const auto d = diagnose(std::span(&r, 1), {}, v);
    EXPECT_TRUE(d) << d.error().text();
    if (!d) continue;
    ++a.flights;
    a.any += !d->findings.empty();
    for (const Finding& f : d->findings) {
      if (f.effect != "rotor_thrust_scale") continue;
      const bool third = f.channels.front() == "rotor3";
      (third ? a.rotor3 : a.other_rotor)++;
      if (third) a.mean_scale += f.parameters[0].value;
    }
  }
  if (a.rotor3 > 0) a.mean_scale /= a.rotor3;
  return a;
}

TEST(SignalSets, ADamagedPropellerIsFoundFromMotorCommandsAlone) {
  if (!std::filesystem::exists(flights() / "crazyflie_damaged_propeller"))
    GTEST_SKIP() << "no recordings at " << flights() << "; set OMNIFLIGHT_REAL_DATA";
  const Answers normal = answers("normal_flight");
  EXPECT_EQ(normal.flights, 7);
  EXPECT_EQ(normal.any, 0);
  const Answers three = answers("cut_propeller_M3_3mm"), both = answers("cut_propeller_M3_3mm_3mm_41mm"),
                most = answers("cut_propeller_M3_3.5mm_3.5mm_40mm");
  for (const Answers* a : {&three, &both, &most}) {
    EXPECT_EQ(a->rotor3, a->flights);
    EXPECT_EQ(a->other_rotor, 0);
  }
  EXPECT_LT(both.mean_scale, three.mean_scale);
  EXPECT_LT(most.mean_scale, both.mean_scale);
  // an added weight is no damage
  for (const char* folder :
       {"add_weight_W1_near_M3_M4", "add_weight_W1_near_M4", "weight_on_string_W2_near_M3"}) {
    const Answers a = answers(folder);
    EXPECT_EQ(a.rotor3 + a.other_rotor, 0) << folder;
  }
}

/// Every flight that is named at all, named for rotor 3; its mean change of thrust.
double change_of_rotor_3(const std::string& folder, const Options& o) {
  double sum = 0;
  int count = 0;
  for (const recording::Recording& r : all_in(folder)) {
    const auto d = diagnose(std::span(&r, 1), {}, load("crazyflie_brushed"), o);
    EXPECT_TRUE(d) << d.error().text();
    if (!d) continue;
    ++count;
    for (const Finding& f : d->findings) {
      EXPECT_EQ(f.effect, "rotor_thrust_scale") << folder << ": " << d->summary;
      EXPECT_EQ(f.channels.front(), "rotor3") << folder << ": " << d->summary;
      EXPECT_LT(f.parameters[0].low, f.parameters[0].value);
      EXPECT_GT(f.parameters[0].high, f.parameters[0].value);
      EXPECT_LT(f.parameters[0].high, 0) << d->summary;
      sum += f.parameters[0].value;
    }
  }
  return sum / std::max(1, count);
}

/// A good flight of the same vehicle is a finer measure than what motors of one kind differ by. Cuts of 1 and
/// 2 mm stay within the scatter of the good flights, which were flown in three batches.
TEST(SignalSets, ADamagedPropellerGrowsWithTheCutAgainstABaseline) {
  if (!std::filesystem::exists(flights() / "crazyflie_damaged_propeller"))
    GTEST_SKIP() << "no recordings at " << flights() << "; set OMNIFLIGHT_REAL_DATA";
  Options o;
  o.baseline = all_in("normal_flight");
  const double three = change_of_rotor_3("cut_propeller_M3_3mm", o),
               both = change_of_rotor_3("cut_propeller_M3_3mm_3mm_41mm", o),
               most = change_of_rotor_3("cut_propeller_M3_3.5mm_3.5mm_40mm", o);
  EXPECT_LT(three, 0);
  EXPECT_LT(both, three);
  EXPECT_LT(most, both);
  EXPECT_LE(three, change_of_rotor_3("cut_propeller_M3_2mm", o));
  // each good flight against the others is nothing
  for (std::size_t k = 0; k < o.baseline.size(); ++k) {
    Options others = o;
    others.baseline.erase(others.baseline.begin() + static_cast<std::ptrdiff_t>(k));
    const auto d = diagnose(std::span(&o.baseline[k], 1), {}, load("crazyflie_brushed"), others);
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_EQ(d->verdict, Verdict::nothing_missing) << d->summary;
  }
  o.baseline.resize(2);
  const auto few = diagnose(std::span(o.baseline.data(), 1), {}, load("crazyflie_brushed"), o);
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().text().find("--baseline"), std::string::npos) << few.error().text();
}

}  // namespace
}  // namespace omniflight::diagnosis
