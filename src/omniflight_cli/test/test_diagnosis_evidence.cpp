// The chain of evidence on the page of a diagnosis, and the picture of the flight that it proposes.
#include <gtest/gtest.h>

#include <algorithm>

#include "../src/diagnosis_evidence.hpp"

namespace omniflight::cli {
namespace {

using diagnosis::Diagnosis;

/// A load that Fz shows clearly and Fx hardly; the fit leaves little of either.
Diagnosis loaded() {
  Diagnosis d;
  d.mismatch.resize(2);
  d.mismatch[0].channel = "Fx", d.mismatch[0].unit = "N", d.mismatch[0].rms = 0.05;
  d.mismatch[1].channel = "Fz", d.mismatch[1].unit = "N", d.mismatch[1].rms = 4.0;
  for (auto& m : d.mismatch) m.noise_rms = 0.04;
  d.findings.resize(1);
  d.findings[0].effect = "payload_mass";
  d.fit.in_sample = {{"", "Fx", "N", 0.05, 0.04}, {"", "Fz", "N", 4.0, 0.05}};
  d.fit.held_out = {{"a", "Fz", "N", 3.0, 0.3}, {"b", "Fz", "N", 4.0, 0.4}, {"b", "Fx", "N", 0.04, 0.05}};
  d.fit.rollout = {{0.5, "position", "m", 0.4, 0.01},
                   {2.0, "position", "m", 6.0, 0.1},
                   {2.0, "attitude", "deg", 1.0, 2.0}};
  const char* alone = "evidence alone against nothing";
  d.decisions = {
      {"wind", alone, 3, 4, "", "refused, posterior inclusion 0.010"},
      {"thrust_scale", alone, 50, 4, "", "refused, posterior inclusion 0.000"},
      {"payload_mass", alone, 90, 4, "", "kept, posterior inclusion 1.000"},
      {"gust", "whether these recordings can show it", 0, 0, "", "not asked: its force is random"}};
  return d;
}

TEST(DiagnosisEvidence, BeginsWithWhatStandsOutAndFollowsItToFlightsThatNoFitTouched) {
  const auto steps = evidence(loaded());
  ASSERT_EQ(steps.size(), 5u);
  EXPECT_EQ(steps[0].answer, "Fz: 4 N RMS where 0.04 N is noise");
  EXPECT_EQ(steps[1].answer, "Fz: 4 N RMS before, 0.05 N after");
  // sqrt((3^2 + 4^2) / 2) and a tenth of it
  EXPECT_EQ(steps[2].answer, "Yes: Fz: 3.54 N RMS before, 0.354 N after, over 2 stretches");
  EXPECT_EQ(steps[3].answer,
            "Yes: position 2 s ahead from the rotor speeds alone: 6 m RMS before, 0.1 m after");
  EXPECT_EQ(steps[4].answer,
            "3 effects and forms of unknown physics; 1 kept, 2 refused as improbable beside what is named; 1 "
            "were not asked, one by one below");
}

TEST(DiagnosisEvidence, TellsOfBlowsAndNotOfWhatChanceMakes) {
  Diagnosis d = loaded();
  d.remaining = {{"Fx", "N", 0.04, 0.04, 0.0, 2, 0.3, 1.0}, {"Fz", "N", 0.05, 0.04, 0.1, 42, 4.21, 41.27}};
  const auto steps = evidence(d);
  ASSERT_EQ(steps.size(), 6u);
  EXPECT_EQ(
      steps[1].answer,
      "Fz: 42 lone samples of up to 4.2 N, the largest at 41.27 s: blows, snatches or faults of a sensor");
}

TEST(DiagnosisEvidence, AModelThatMakesItWorseIsSaidToDoSo) {
  Diagnosis d = loaded();
  for (auto& f : d.fit.held_out) std::swap(f.rms_before, f.rms_after);
  EXPECT_TRUE(evidence(d)[2].answer.starts_with("No: "));
}

TEST(DiagnosisEvidence, WithoutADifferenceThereIsNone) {
  EXPECT_TRUE(evidence(Diagnosis{}).empty());
  Diagnosis d = loaded();
  d.findings.clear();
  EXPECT_EQ(evidence(d).size(), 1u) << "nothing is named: only what differs is known";
  d = loaded();
  d.verdict = diagnosis::Verdict::unfinished;
  EXPECT_TRUE(evidence(d).empty()) << "no claim before the search has ended";
}

TEST(DiagnosisEvidence, AskedEffectsHaveTheKeptOnesFirstAndThoseNotAskedLast) {
  const auto table = asked_effects(loaded());
  std::vector<std::string> names;
  for (const auto& row : table.rows) names.push_back(std::get<std::string>(row[0].value));
  EXPECT_EQ(names, (std::vector<std::string>{"payload_mass", "thrust_scale", "wind", "gust"}));
}

TEST(NextFlightPicture, IsThePathOfTheFlightInTheMissionsFile) {
  diagnosis::NextFlight next;
  EXPECT_FALSE(next_flight_path(next));
  next.proposed.resize(2);
  next.proposed[0].name = "hop", next.proposed[0].waypoints.resize(1);
  next.proposed[0].separations_sigma = {1};
  auto& chosen = next.proposed[1];
  chosen.name = "lean", chosen.start = Vec3(1, 2, 3), chosen.separations_sigma = {5};
  chosen.waypoints = {{Vec3(1, 0, 0), Vec3(0, 30, 0)}, {Vec3(0, 0, -2), Vec3(0, 0, 90)}};
  next.mission = "next_flight.yaml", next.separations_sigma = {5};
  const auto plot = next_flight_path(next);
  ASSERT_TRUE(plot);
  EXPECT_NE(plot->title.find("lean"), std::string::npos);
  EXPECT_DOUBLE_EQ(plot->x.front(), 1);
  EXPECT_DOUBLE_EQ(plot->x.back(), 2);
  EXPECT_DOUBLE_EQ(plot->z.back(), 1);
  EXPECT_NEAR(*std::max_element(plot->value.begin(), plot->value.end()), 30, 1e-9);
  EXPECT_NEAR(plot->value.back(), 0, 1e-6) << "yaw is no lean";
}

}  // namespace
}  // namespace omniflight::cli
