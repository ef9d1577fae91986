// Cases: drawn fairly, flown on the independent plant, and all alike from the outside.
#include <gtest/gtest.h>

#include <set>

#include "case_make.hpp"
#include "case_next.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

vehicle::Vehicle omnimorph() {
  auto v = vehicle::load_vehicle(OMNIFLIGHT_SOURCE_ROOT "/configs/vehicles/omnimorph/omnimorph.yaml");
  EXPECT_TRUE(v) << (v ? "" : v.error().text());
  return *v;
}

TEST(Draw, IsTheSameForASaltAndAnotherForAnother) {
  const auto v = omnimorph();
  const auto m = mechanisms(v);
  const DrawOptions o{.salt = "a salt of a test", .sealed = true, .cases = 240, .nulls = 300, .level = ""};
  const auto a = draw_cases(o, m), b = draw_cases(o, m);
  DrawOptions other = o;
  other.salt = "another salt";
  const auto c = draw_cases(other, m);
  ASSERT_EQ(a.size(), 540u);
  int same = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].parts, b[k].parts);
    same += a[k].parts == c[k].parts && a[k].kind == c[k].kind;
  }
  EXPECT_LT(same, 300);  // nulls meet by chance
}

TEST(Draw, HasTheSizesOfTheProtocol) {
  const auto v = omnimorph();
  const auto m = mechanisms(v);
  const auto cases =
      draw_cases({.salt = "a salt of a test", .sealed = true, .cases = 240, .nulls = 300, .level = ""}, m);
  std::map<Kind, int> kinds;
  std::set<std::string> ids, effects;
  for (const auto& c : cases) {
    ++kinds[c.kind];
    ids.insert(c.id);
    for (const auto k : c.parts) effects.insert(m[k].id);
    EXPECT_EQ(c.parts.empty(), c.kind == Kind::null || c.kind == Kind::decoy);
  }
  EXPECT_EQ(ids.size(), 540u);
  EXPECT_EQ(kinds[Kind::null] + kinds[Kind::decoy], 300);
  EXPECT_GE(kinds[Kind::single], 140);
  EXPECT_GE(kinds[Kind::pair] + kinds[Kind::triple], 50);
  EXPECT_GE(kinds[Kind::unknown], 20);
  EXPECT_GE(effects.size(), 25u);
}

TEST(Draw, TuningAndSealedBoxesNeverMeet) {
  Random random(3);
  const auto strip = [](double u) { return static_cast<int>(u * 8) % 2; };
  for (int k = 0; k < 100; ++k) {
    for (const double u : draw_shape(random, true).u) EXPECT_EQ(strip(u), 1);
    for (const double u : draw_shape(random, false).u) EXPECT_EQ(strip(u), 0);
  }
}

TEST(Path, ReferencesAreConsistentDerivatives) {
  Random random(5);
  for (const Path& p : {path_t1(), path_t2(), path_designed(random)})
    for (const double t : {3.7, 9.1, 22.2, 41.3, 57.9}) {
      const double h = 1e-4;
      const Reference a = p.at(t - h), r = p.at(t), b = p.at(t + h);
      EXPECT_LT((r.v_WB_W - (b.p_WB - a.p_WB) / (2 * h)).norm(), 1e-6) << p.name << " " << t;
      EXPECT_LT((r.a_WB_W - (b.v_WB_W - a.v_WB_W) / (2 * h)).norm(), 1e-6) << p.name << " " << t;
      EXPECT_LT((r.w_WB_B - log_rotation(a.q_WB.conjugate() * b.q_WB) / (2 * h)).norm(), 1e-6)
          << p.name << " " << t;
      EXPECT_LT((r.dw_WB_B - (b.w_WB_B - a.w_WB_B) / (2 * h)).norm(), 1e-5) << p.name << " " << t;
    }
}

TEST(Case, DesignedFlightsExciteWithoutReversingARotor) {
  const auto v = omnimorph();
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    FlightSetup s;
    Random random(seed);
    s.path = path_designed(random);
    s.flown = s.told = usual_gains();
    s.record = false;
    auto flown = fly(v, s);
    ASSERT_TRUE(flown) << flown.error().text();
    EXPECT_GT(flown->lowest_thrust, v.rotors[0].min_thrust);
    double lean = 0, alpha = 0, slowest = 1e9, fastest = 0;
    for (double t = 0; t < s.path.duration; t += 0.05) {
      const Reference r = s.path.at(t);
      lean = std::max(lean, std::acos((r.q_WB * Vec3::UnitZ()).z()));
      alpha = std::max(alpha, r.alpha);
      slowest = std::min(slowest, r.v_WB_W.norm());
      fastest = std::max(fastest, r.v_WB_W.norm());
    }
    EXPECT_GT(lean, to_radians(32));
    EXPECT_GT(alpha, to_radians(57));
    EXPECT_LE(alpha, v.tilt.max);
    EXPECT_LT(slowest, 0.05);
    EXPECT_GT(fastest, 0.5);
    EXPECT_LT(flown->saturated, 1e-9);
    EXPECT_GT(flown->dw, 0.5);
    EXPECT_LT(flown->command[0], 0.01);  // commands and the nominal lag give the thrusts
  }
}

TEST(Case, IntegralActionHidesALoadFromTrackingButNotFromTheWrench) {
  const auto v = omnimorph();
  FlightSetup s;
  s.path = path_t1();
  s.path.duration = 12;
  s.flown = s.told = usual_gains();
  s.record = false;
  auto nominal = fly(v, s);
  s.world.body.payload = 0.25;
  auto loaded = fly(v, s);
  ASSERT_TRUE(nominal && loaded);
  EXPECT_LT(nominal->wrench[2], 0.01);
  EXPECT_NEAR(loaded->wrench[2], 0.25 * kGravity, 0.1);
  EXPECT_LT(loaded->position_rms, 0.05);
}

TEST(Case, LooksTheSameFromTheOutsideWhateverIsInIt) {
  const auto v = omnimorph();
  const auto m = mechanisms(v);
  auto plans =
      draw_cases({.salt = "a salt of a test", .sealed = true, .cases = 0, .nulls = 4, .level = ""}, m);
  CasePlan loaded = plans[0];
  loaded.kind = Kind::single;
  loaded.magnitude = 1;
  loaded.parts = {0};
  loaded.decoy.clear();
  loaded.nuisances = false;
  auto a = make_case(v, m, plans[1], "a salt of a test", true),
       b = make_case(v, m, loaded, "a salt of a test", true);
  ASSERT_TRUE(a) << a.error().text();
  ASSERT_TRUE(b) << b.error().text();
  EXPECT_EQ(a->recording.size(), kRecordingBytes);
  EXPECT_EQ(b->recording.size(), kRecordingBytes);
  EXPECT_EQ(a->told.size(), b->told.size());
  EXPECT_EQ(b->truth.effects.at(0).id, m[0].id);
  EXPECT_NEAR(b->truth.effects.at(0).sigma, 1, 0.1);
  const std::string file = ::testing::TempDir() + "/prove_case.csv.gz";
  ASSERT_TRUE(files::write_file_atomic(file, b->recording));
  auto r = recording::load(file);
  ASSERT_TRUE(r) << r.error().text();
  for (const auto& name : r->signal_names()) EXPECT_EQ(name.find("truth"), std::string::npos) << name;
  for (const char* name :
       {"position", "attitude", "acc", "gyro", "rotor_speed", "rotor_command", "qddr", "ref_position"})
    EXPECT_NE(r->find(name), nullptr) << name;
  EXPECT_GT(r->duration_s, 55);
}

TEST(Case, WhatIsToldDoesNotSayWhatKindOfCaseItIs) {
  const auto v = omnimorph();
  const auto m = mechanisms(v);
  const auto plans =
      draw_cases({.salt = "a salt of a test", .sealed = true, .cases = 240, .nulls = 300, .level = ""}, m);
  int nominal = 0, hidden = 0;
  for (const CasePlan& p : plans)
    if (p.decoy == kRetuned) ++(p.parts.empty() ? nominal : hidden);
  EXPECT_NEAR(nominal, 300 * kDecoyShare / kDecoys, 1);
  EXPECT_GE(hidden, 6);
  EXPECT_LE(hidden, 22);
  std::set<std::string> told;
  for (const char* decoy : {"", "noisy sensors", "slow turbulence", "strong turbulence"}) {
    CasePlan p{.id = "case-0001", .level = "L6", .flight = "T1", .decoy = decoy, .kind = Kind::decoy};
    auto made = make_case(v, m, p, "a salt of a test", true);
    ASSERT_TRUE(made) << made.error().text();
    told.insert(made->told);
  }
  EXPECT_EQ(told.size(), 1u);
}

constexpr const char* kNext = R"(schema: omniflight.mission/1
name: ascent
alpha_deg: 42
limits: {speed_mps: 0.5, acceleration_mps2: 1, rate_dps: 60, angular_acceleration_dps2: 40}
start: {position: [0, 0, 0.9], attitude: {rpy_deg: [0, 0, 0]}, hold_s: 3}
waypoints:
  - {by: [0, 0, 0.4], hold_s: 2}
  - {attitude: {rpy_deg: [20, 0, 0]}, hold_s: 2}
)";

TEST(Next, AProposedMissionBecomesAPathFromRestToRest) {
  auto p = read_next_flight(kNext, "next.yaml");
  ASSERT_TRUE(p) << p.error().text();
  EXPECT_NEAR(p->at(0).p_WB.z(), 0.9, 1e-12);
  EXPECT_NEAR(p->at(p->duration).p_WB.z(), 1.3, 1e-12);
  EXPECT_NEAR(roll_pitch_yaw(p->at(p->duration).q_WB).x(), to_radians(20), 1e-9);
  EXPECT_NEAR(p->at(0).alpha, to_radians(42), 1e-12);
  double fastest = 0, hardest = 0, turning = 0;
  for (double t = 0; t < p->duration; t += 0.01) {
    turning = std::max(turning, p->at(t).dw_WB_B.norm());
    fastest = std::max(fastest, p->at(t).v_WB_W.norm());
    hardest = std::max(hardest, p->at(t).a_WB_W.norm());
  }
  EXPECT_LE(fastest, 0.5 + 1e-9);
  EXPECT_LE(hardest, 1.0 + 1e-2);
  EXPECT_LE(turning, to_radians(40) + 1e-2);
  EXPECT_GT(fastest, 0.2);
}

TEST(Next, AQuickRockIsTaken) {  // what a diagnosis proposes against load and thrust scale
  std::string text = kNext;
  const std::string slow = "rate_dps: 60, angular_acceleration_dps2: 40";
  text.replace(text.find(slow), slow.size(), "rate_dps: 212, angular_acceleration_dps2: 1320");
  auto p = read_next_flight(text, "next.yaml");
  ASSERT_TRUE(p) << p.error().text();
}

TEST(Next, WhatAnAnswerMayNotAskForIsRefusedByName) {
  const auto with = [](const char* what, const char* instead) {
    std::string text = kNext;
    return text.replace(text.find(what), std::string_view(what).size(), instead);
  };
  std::string hours;
  for (int k = 0; k < 120; ++k) hours += "  - {hold_s: 60}\n";
  for (const auto& [text, words] : {std::pair{with("by: [0, 0, 0.4]", "by: [0, 0, 40]"), "by"},
                                    {with("alpha_deg: 42", "alpha_deg: 80"), "alpha_deg"},
                                    {with("mission/1", "mission/9"), "schema"},
                                    {with("name: ascent", "effect: payload"), "effect"},
                                    {std::string(kNext) + hours, "660 s"}}) {
    auto p = read_next_flight(text, "next.yaml");
    ASSERT_FALSE(p) << words;
    EXPECT_NE(p.error().text().find(words), std::string::npos) << p.error().text();
  }
}

TEST(Next, TheSameWorldIsFlownAgain) {
  const auto v = omnimorph();
  const auto m = mechanisms(v);
  auto plans =
      draw_cases({.salt = "a salt of a test", .sealed = true, .cases = 0, .nulls = 1, .level = ""}, m);
  plans[0].kind = Kind::single;
  plans[0].magnitude = 1;
  plans[0].parts = {0};
  plans[0].decoy.clear();
  plans[0].nuisances = false;
  ASSERT_EQ(m[0].id, "payload_mass");
  auto path = read_next_flight(kNext, "next.yaml");
  ASSERT_TRUE(path);
  auto first = make_case(v, m, plans[0], "a salt of a test", true);
  auto again = fly_again(v, m, plans[0], "a salt of a test", true, *path);
  ASSERT_TRUE(first && again);
  EXPECT_TRUE(again->truth.effects.empty()) << "the truth stays in the seal";
  // mean thrust at rest tells the hidden mass: m = T / g, the same in both
  const auto weight = [&](const std::string& bytes) {
    const std::string file = ::testing::TempDir() + "/prove_next.csv.gz";
    EXPECT_TRUE(files::write_file_atomic(file, bytes));
    auto r = recording::load(file);
    EXPECT_TRUE(r);
    const auto& speed = r->signals.at("rotor_speed");
    const double alpha = r->signals.at("alpha").values(10, 0);
    double lift = 0;
    int n = 0;
    for (Eigen::Index i = 0; i < speed.size() && speed.t_s[static_cast<std::size_t>(i)] < 2.0; ++i) {
      if (speed.t_s[static_cast<std::size_t>(i)] < 1.0 || !speed.values.row(i).allFinite()) continue;
      vehicle::RotorVector u(v.rotor_count());
      for (int k = 0; k < v.rotor_count(); ++k)
        u[k] = v.rotors[static_cast<std::size_t>(k)].thrust(speed.values(i, k));
      lift += (v.allocation_matrix(alpha) * u)[2];
      ++n;
    }
    return lift / std::max(1, n);
  };
  const double mass = weight(first->recording) / kGravity, other = weight(again->recording) / kGravity;
  EXPECT_NEAR(mass, other, 0.03);
  EXPECT_GT(std::abs(mass - v.mass), 0.01);
}

TEST(Graph, TheGeneratorHoldsNothingOfTheProjectsDynamics) {
  const auto holds = [](const std::string& bytes, const char* name) {
    return bytes.find(name) != std::string::npos;
  };
  auto generator = files::read_file(PROVE_GENERATE, std::size_t{256} << 20);
  ASSERT_TRUE(generator) << generator.error().text();
  // mangled namespaces: omniflight::physics, ::simulation, ::diagnosis
  for (const char* room : {"10omniflight7physics", "10omniflight10simulation", "10omniflight9diagnosis"})
    EXPECT_FALSE(holds(*generator, room)) << room;
  EXPECT_TRUE(holds(*generator, "10omniflight5proof"))
      << "the symbols were stripped, so this test says nothing";
}

}  // namespace
}  // namespace omniflight::proof
