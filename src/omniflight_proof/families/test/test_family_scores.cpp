// Scoring by family: fixed answers to fixed cases, with the figures worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "family_scores.hpp"

namespace omniflight::proof {
namespace {

FamilyCase hidden(const std::string& id, Kind kind, double sigma, std::vector<std::string> effects) {
  FamilyCase c;
  c.truth.id = id;
  c.truth.kind = kind;
  c.truth.magnitude = sigma;
  c.where = {.vehicle = "quadrotor_37g",
             .controller = "indi",
             .told_gains = "not told",
             .start = "rest",
             .manoeuvre = "eight",
             .signals = "imu+speed",
             .turbulence = "ou",
             .noise = "white",
             .calibration = "exact",
             .tilt = "none"};
  for (const std::string& e : effects) {
    c.truth.effects.push_back({e, "wrench", "a way", sigma, {}, {}});
    c.sizes.push_back({{}, sigma, "Fz", true});
  }
  return c;
}

Answer said(std::vector<std::pair<std::string, double>> findings) {
  Answer a;
  a.given = true;
  a.verdict = findings.empty() ? "nothing_missing" : "explained";
  for (auto& [id, p] : findings) {
    AnsweredEffect e;
    e.id = id;
    e.stage = "wrench";
    e.probability = p;
    e.set = {id};
    a.findings.push_back(e);
  }
  return a;
}

const FamilyLine& find(const FamilyScores& s, const std::string& name) {
  for (const FamilyLine& l : s.lines)
    if (l.name == name) return l;
  ADD_FAILURE() << "no line " << name;
  return s.lines[0];
}
const GroupScores& find(const FamilyScores& s, const std::string& axis, const std::string& value) {
  for (const GroupScores& g : s.groups)
    if (g.axis == axis && g.value == value) return g;
  ADD_FAILURE() << "no group " << axis << " = " << value;
  return s.groups[0];
}

TEST(FamilyScores, CountWhatWasSaidOfWhatIsSo) {
  std::vector<FamilyCase> cases{hidden("a", Kind::null, 0, {}),
                                hidden("b", Kind::null, 0, {}),
                                hidden("c", Kind::single, 1, {"payload_mass"}),
                                hidden("d", Kind::single, 1, {"rotor_drag"}),
                                hidden("e", Kind::single, 3, {"com_offset"}),
                                hidden("f", Kind::pair, 1, {"constant_pull", "rotor_inertia"}),
                                hidden("g", Kind::unknown, 1, {"unknown"}),
                                hidden("h", Kind::single, 1, {"guide_friction"})};
  cases[6].truth.effects[0].variables = {"speed"};
  cases[4].truth.effects[0].parameters = {{"x", 0.01, 0.02}};
  cases[4].where.vehicle = "omnimorph";
  std::map<std::string, Answer> answers;
  answers["a"] = said({});
  answers["b"] = said({{"rotor_drag", 0.7}});
  answers["c"] = said({{"thrust_scale", 0.8}});  // an alias
  answers["d"] = said({{"parasitic_drag", 0.6}});
  answers["d"].findings[0].set = {"parasitic_drag", "rotor_drag"};
  answers["e"] = said({{"com_offset", 0.95}});
  answers["e"].findings[0].parameters = {{"x", 0.012, 0.009, 0.015}};
  answers["f"] = said({{"constant_pull", 0.9}, {"rotor_inertia", 0.8}});
  answers["g"] = said({});
  answers["g"].verdict = "unexplained";
  answers["g"].unknown = {{"wrench", {"speed"}}};
  // h is not answered
  const FamilyScores s = score_families(cases, answers);
  EXPECT_EQ(find(s, "false alarms").rate.k, 1);
  EXPECT_EQ(find(s, "false alarms").rate.n, 2);
  EXPECT_EQ(find(s, "detection at 1 sigma").rate.k, 4);
  EXPECT_EQ(find(s, "detection at 1 sigma").rate.n, 5);
  EXPECT_EQ(find(s, "top-1 at 1 sigma").rate.k, 1);
  EXPECT_EQ(find(s, "top-1 at 1 sigma").rate.n, 3);
  EXPECT_EQ(find(s, "top-1 at 3 sigma").rate.k, 1);
  EXPECT_EQ(find(s, "truth in the stated set").rate.k, 3);
  EXPECT_EQ(find(s, "truth in the stated set").rate.n, 3);
  EXPECT_NEAR(find(s, "mean size of the set").value, 4.0 / 3, 1e-12);
  EXPECT_EQ(find(s, "two effects exact").rate.k, 1);
  EXPECT_EQ(find(s, "out of library: unknown, stage and variable right").rate.k, 1);
  EXPECT_EQ(find(s, "95 % intervals cover").rate.k, 1);
  EXPECT_NEAR(find(s, "quadrotors behind the fully actuated, top-1").value, 1 - 1.0 / 3, 1e-12);
  // statements .7 no, .8 yes, .6 no, .95 yes, .9 yes, .8 yes; bins .6: .6/0, .7: .7/0, .8: .8/1 (2), .9:
  // .925/1 (2)
  EXPECT_NEAR(s.reliability.expected_error, (0.6 + 0.7 + 2 * 0.2 + 2 * 0.075) / 6, 1e-12);
  EXPECT_EQ(find(s, "vehicle", "omnimorph").cases, 1);
  EXPECT_EQ(find(s, "effect", "rotor_drag").covered.k, 1);
  EXPECT_EQ(find(s, "all", "").unanswered.k, 1);
  ASSERT_FALSE(s.risk.empty());
  EXPECT_DOUBLE_EQ(s.risk.back().answered, 1);
  EXPECT_DOUBLE_EQ(s.risk.front().accuracy, 1) << "the surest answers are right";
  const std::string text = to_text(s);
  EXPECT_NE(text.find("omnimorph"), std::string::npos);
  EXPECT_EQ(to_json(s)["cases"].size(), 8u);
}

TEST(FamilyScores, NamingWhatIsThereBesidesIsNoAlarm) {
  FamilyCase c = hidden("a", Kind::null, 0, {});
  c.truth.present = {"controller_mismatch"};
  EXPECT_FALSE(judge(c, said({{"controller_mismatch", 0.9}})).alarm);
  EXPECT_TRUE(judge(c, said({{"payload_mass", 0.9}})).alarm);
  EXPECT_TRUE(judge(c, said({{"controller_mismatch", 0.9}, {"payload_mass", 0.9}})).alarm);
}

TEST(FamilyScores, UnfinishedAndMissingAnswersAreNone) {
  const FamilyCase c = hidden("a", Kind::single, 3, {"payload_mass"});
  Answer a = said({{"payload_mass", 0.9}});
  EXPECT_TRUE(judge(c, a).top1);
  for (const char* verdict : {"unfinished", "unusable", "checked"}) {
    a.verdict = verdict;
    EXPECT_FALSE(judge(c, a).given) << verdict;
    EXPECT_FALSE(judge(c, a).alarm) << verdict;
  }
}

TEST(FamilySeal, ComesBackAsItWasAndRefusesOthers) {
  FamilyCase c = hidden("case-0001", Kind::single, 1, {"payload_mass"});
  c.unseen = {"vehicle"};
  c.oracle = {true, 12, 7, "constant_pull", true};
  c.where.low = true;
  const FamilySeal seal{"salt", "tuning", "sha", {c}};
  auto back = read_family_seal(to_json(seal), "here");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(to_json(*back), to_json(seal));
  auto bad = read_family_seal("{\"schema\": \"omniflight.proof_seal/1\"}", "there.json");
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().text().find("there.json"), std::string::npos);
  std::string broken = to_json(seal);
  broken.replace(broken.find("\"single\""), 8, "\"double\"");
  auto kind = read_family_seal(broken, "there.json");
  ASSERT_FALSE(kind);
  EXPECT_NE(kind.error().text().find("cases[0]"), std::string::npos) << kind.error().text();
}

}  // namespace
}  // namespace omniflight::proof
