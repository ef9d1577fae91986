// First sentences of reports.
#include <gtest/gtest.h>

#include <cmath>

#include "../src/pilot_words.hpp"

namespace omniflight::cli {
namespace {

using diagnosis::Diagnosis;
using diagnosis::Finding;
using diagnosis::ParameterValue;
using diagnosis::Verdict;

/// A finding with a tight interval about every value.
Finding finding(const std::string& effect, std::vector<std::pair<std::string, double>> values,
                physics::Stage stage = physics::Stage::wrench) {
  Finding f;
  f.effect = effect;
  f.stage = stage;
  for (const auto& [name, value] : values)
    f.parameters.push_back(
        {name, "", "", value, value - 1e-3 * std::abs(value), value + 1e-3 * std::abs(value)});
  return f;
}

Diagnosis answer(Verdict verdict, std::vector<Finding> findings = {}) {
  Diagnosis d;
  d.verdict = verdict;
  d.findings = std::move(findings);
  return d;
}

const Finding kHeavy = finding("payload_mass", {{"mass", 0.28}});
const Finding kCable =
    finding("hung_cable", {{"linear_density", 0.3}, {"start_height", 1.06}, {"length", 5}});

TEST(PilotWords, SayWhatIsWrongWithTheVehicle) {
  EXPECT_EQ(first_sentence(answer(Verdict::explained, {kHeavy, kCable})),
            "0.28 kg too heavy; a cable of 0.30 kg/m from 1.06 m up");
  EXPECT_EQ(pilot_words(finding("payload_mass", {{"mass", -0.0027}})), "2.7 g too light");
  EXPECT_EQ(pilot_words(finding("rotor_thrust_scale", {{"scale_3", -0.12}})),
            "rotor 3 gives 12 % less thrust than modelled");
  EXPECT_EQ(pilot_words(finding("constant_pull", {{"x", 0}, {"y", 0}, {"z", -1.5}})),
            "a steady pull of 1.5 N downward");
  EXPECT_EQ(pilot_words(finding("com_offset", {{"x", 0.012}, {"y", -0.004}, {"z", 0}})),
            "the centre of mass is 12 mm forward, 4 mm to the right of its place");
  // an effect without words of its own: its term and its largest number
  EXPECT_EQ(pilot_words(finding("rotor_drag", {{"coefficient", 0.0001}})),
            "rotor drag (H-force) (coefficient 0.0001)");
}

TEST(PilotWords, EveryEffectOfTheCatalogueHasSome) {
  for (const physics::Effect* e : physics::builtin_effects()) {
    Finding f = finding(e->info().id, {});
    for (const auto& p : e->info().parameters)
      f.parameters.push_back({p.name, p.symbol, p.unit, p.typical, p.typical, p.typical});
    const std::string words = pilot_words(f);
    EXPECT_FALSE(words.empty()) << e->info().id;
    EXPECT_EQ(words.find("nan"), std::string::npos) << words;
    EXPECT_EQ(words.find("  "), std::string::npos) << words;
  }
}

TEST(PilotWords, WhatTheFlightDoesNotBoundIsNotGiven) {
  Finding cable = kCable;
  cable.parameters[1].low = -1, cable.parameters[1].high = 3;  // all that the effect allows
  EXPECT_EQ(pilot_words(cable), "a cable of 0.30 kg/m");
  Finding heavy = kHeavy;
  heavy.parameters[0].low = -0.5, heavy.parameters[0].high = 2;
  EXPECT_EQ(pilot_words(heavy), "payload mass, its size not identifiable");
}

TEST(PilotWords, ControlAndSensorsAreNoPhysicsOfTheVehicle) {
  const Diagnosis sensor = answer(
      Verdict::explained, {finding("accelerometer_error", {{"bias_z", 0.12}}, physics::Stage::sensing)});
  EXPECT_FALSE(names_physics(sensor));
  EXPECT_EQ(first_sentence(sensor), "The vehicle flies as modelled; the accelerometer is off by 0.12 m/s2");
  const Diagnosis control =
      answer(Verdict::explained, {finding("controller_mismatch", {{"force", 0.2}}, physics::Stage::control)});
  EXPECT_EQ(first_sentence(control), "The vehicle flies as modelled; the gains flown are not those told");
  Diagnosis both = sensor;
  both.findings.push_back(kHeavy);
  EXPECT_TRUE(names_physics(both));
  EXPECT_EQ(first_sentence(both), "0.28 kg too heavy; the accelerometer is off by 0.12 m/s2");
}

TEST(PilotWords, RivalsAndTheUnknownAreNamed) {
  Finding f = kHeavy;
  f.cannot_be_told_apart_from = {"thrust_scale", "constant_pull"};
  f.rivals = 1;
  EXPECT_EQ(first_sentence(answer(Verdict::ambiguous, {f})), "0.28 kg too heavy or thrust coefficient error");
  Diagnosis d = answer(Verdict::unexplained, {kHeavy});
  d.unexplained.emplace_back().channel = "Fz";
  EXPECT_EQ(first_sentence(d), "0.28 kg too heavy; something in Fz that no known effect explains");
}

TEST(PilotWords, WithoutAnAnswerNoneIsClaimed) {
  for (const Verdict v : {Verdict::checked, Verdict::unfinished, Verdict::unusable}) {
    const std::string words = first_sentence(answer(v, {kHeavy}));
    for (const char* claim : {"heavy", "explain", "as modelled", "found"})
      EXPECT_EQ(words.find(claim), std::string::npos) << words;
  }
  EXPECT_EQ(first_sentence(answer(Verdict::nothing_missing)), "The model explains this flight");
}

}  // namespace
}  // namespace omniflight::cli
