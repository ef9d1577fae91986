#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

const Finding* find(const Diagnosis& d, const std::string& effect) {
  for (const Finding& f : d.findings)
    if (f.effect == effect) return &f;
  return nullptr;
}

Result<Diagnosis> fly_and_diagnose(const std::vector<physics::ActiveEffect>& effects,
                                   const test::Flown& flown, const vehicle::Vehicle& v,
                                   const std::vector<std::string>& only = {}) {
  const recording::Recording r = test::fly(v, effects, flown);
  Options o;
  o.threads = 2;
  o.only = only;
  return diagnose(std::span(&r, 1), {}, v, o);
}

TEST(Diagnose, NamesPayloadAndCableOfATetheredAscent) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown flown;
  flown.duration_s = 60;
  flown.force_noise_N = 0.1;  // at 0.15 N one ascent tells the start height to 3 cm (one sigma) only
  {
    const auto d = fly_and_diagnose({{physics::find_effect("payload_mass"), {0.28}},
                                     {physics::find_effect("hung_cable"), {0.25, 0.62, 5.0}}},
                                    flown, v,
                                    {"payload_mass", "hung_cable", "thrust_scale", "constant_pull",
                                     "catenary", "rotor_drag", "overhead_rope", "cable_pendulum"});
    ASSERT_TRUE(d) << d.error().text();
    const Finding *mass = find(*d, "payload_mass"), *cable = find(*d, "hung_cable");
    ASSERT_TRUE(mass && cable) << d->summary;
    EXPECT_EQ(d->findings.size(), 2u) << d->summary;
    EXPECT_NEAR(mass->parameters[0].value, 0.28, 0.028);
    EXPECT_NEAR(cable->parameters[0].value, 0.25, 0.025);
    EXPECT_NEAR(cable->parameters[1].value, 0.62, 0.05);
    const auto vertical = std::find_if(d->mismatch.begin(), d->mismatch.end(), [](const Mismatch& m) {
      return m.channel == "Fz" && m.stage == physics::Stage::wrench;
    });
    ASSERT_NE(vertical, d->mismatch.end());
    EXPECT_EQ(vertical->frame, "body");
    EXPECT_NE(vertical->where.find("with height above 0."), std::string::npos) << vertical->where;
    for (const ChannelFit& c : d->fit.held_out) {
      if (c.channel != "Fz") continue;
      EXPECT_LT(c.rms_after, 0.2 * c.rms_before) << c.recording;
    }
  }
}

TEST(Diagnose, AnswersNothingMissingOnNominalFlights) {
  const vehicle::Vehicle v = omnimorph();
  // all hundred take minutes: OMNIFLIGHT_LONG=1; of the first five none, of all at most three
  const bool all = std::getenv("OMNIFLIGHT_LONG") != nullptr;
  const std::uint64_t flights = all ? 100 : 5;
  int alarms = 0;
  std::string last;
  for (std::uint64_t seed = 1; seed <= flights; ++seed) {
    test::Flown flown;
    flown.duration_s = 20;
    flown.seed = seed;
    flown.correlation_s = 0.1 + 0.009 * static_cast<double>(seed);  // up to one second
    const auto d = fly_and_diagnose({}, flown, v);
    ASSERT_TRUE(d) << d.error().text();
    if (d->verdict == Verdict::nothing_missing) continue;
    ++alarms;
    last = d->summary;
  }
  RecordProperty("alarms", alarms);
  EXPECT_LE(alarms, all ? 3 : 0) << last;
}

TEST(Diagnose, FindsRotorDragAndWritesTheContract) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown flown;
  flown.side_m = 4.0;
  flown.force_noise_N = 0.03;
  const auto d = fly_and_diagnose({{physics::find_effect("rotor_drag"), {2e-4}}}, flown, v,
                                  {"rotor_drag", "parasitic_drag", "wind", "payload_mass", "constant_pull"});
  ASSERT_TRUE(d) << d.error().text();
  const Finding* drag = find(*d, "rotor_drag");
  ASSERT_TRUE(drag) << d->summary;
  EXPECT_NEAR(drag->parameters[0].value, 2e-4, 5e-5)
      << "noise takes a part of it: see docs/explanation/diagnosis_method.md";
  EXPECT_FALSE(find(*d, "payload_mass")) << d->summary;
  const auto j = nlohmann::json::parse(to_json(*d));
  EXPECT_EQ(j["schema"], "omniflight.diagnosis/1");
  for (const char* key :
       {"inputs", "verdict", "summary", "mismatch", "findings", "unexplained", "fit", "next_flight"})
    EXPECT_TRUE(j.contains(key)) << key;
  for (const char* key : {"in_sample", "held_out", "rollout", "closed_loop", "power"})
    EXPECT_TRUE(j["fit"].contains(key)) << key;
  EXPECT_NE(model_yaml(*d).find("rotor_drag"), std::string::npos);
}

TEST(Diagnose, RefusesWhatItCannotUse) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown flown;
  flown.duration_s = 5;
  recording::Recording r = test::fly(v, {}, flown);
  r.signals.erase("attitude");
  r.signals.erase("rotor_speed");
  auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();  // but judges the sensors that are left
  EXPECT_EQ(d->verdict, Verdict::unusable);
  EXPECT_NE(d->summary.find("no rotor speed"), std::string::npos) << d->summary;
  r = test::fly(v, {}, flown);
  r.signals["rotor_speed"].values.conservativeResize(Eigen::NoChange, 4);
  d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_FALSE(d);
  EXPECT_NE(d.error().text().find("has 4 rotors"), std::string::npos) << d.error().text();
  EXPECT_FALSE(diagnose({}, {}, v));
}

TEST(Diagnose, NamesAStuckRotorSensorAndAFrozenBattery) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown flown;
  flown.duration_s = 20;
  recording::Recording r = test::fly(v, {}, flown);
  r.signals["rotor_speed"].values.block(500, 2, 400, 1).setZero();
  recording::Signal battery = r.signals["alpha"];
  battery.name = "vbat";
  battery.unit = "V";
  battery.values.setConstant(14.8);
  r.signals["vbat"] = battery;
  const auto d = diagnose(std::span(&r, 1), {}, v);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_TRUE(find(*d, "rotor_speed_sensor_fault")) << d->summary;
  EXPECT_EQ(find(*d, "rotor_speed_sensor_fault")->channels[0], "rotor3_speed");
  EXPECT_TRUE(find(*d, "battery_sensor_fault"));
  EXPECT_EQ(d->findings.size(), 2u) << d->summary;
}

}  // namespace
}  // namespace omniflight::diagnosis
