// Figures that need no flight: what is known of them must come out again, and a finding survives its file.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "omniflight_reproduction/figure.hpp"
#include "omniflight_reproduction/flights.hpp"
#include "omniflight_reproduction/printed.hpp"

namespace omniflight::reproduction {
namespace {

const Inputs& inputs() {
  static const Inputs in = [] {
    Inputs out;
    const std::string configs = OMNIFLIGHT_SOURCE_ROOT "/configs/vehicles/";
    out.omnimorph = vehicle::load_vehicle(configs + "omnimorph/omnimorph.yaml").value();
    out.omnicopter = vehicle::load_vehicle(configs + "omnicopter/omnicopter.yaml").value();
    return out;
  }();
  return in;
}

Finding found(const std::string& id) {
  const Figure* figure = find_figure(id);
  if (!figure) throw std::runtime_error("no figure " + id);
  return figure->compute(inputs()).value();
}

const Row& row(const Finding& f, const std::string& key) {
  for (const Row& r : f.rows)
    if (r.key == key) return r;
  throw std::runtime_error("no row " + key);
}

TEST(Printed, EveryNumberIsOfOneFigureThatShowsIt) {
  std::set<std::string> keys;
  for (const Printed& p : printed_numbers()) {
    EXPECT_TRUE(keys.insert(p.key).second) << p.key << " twice";
    EXPECT_GT(std::string(p.because).size(), 5u) << p.key;
    EXPECT_GE(p.tolerance, p.factor ? 1.0 : 0.0) << p.key;
  }
}

TEST(Figures, OfChapter5AreWhatIsKnownOfThem) {
  const Finding forces = found("5.3");
  EXPECT_EQ(forces.verdict(), Verdict::explained);
  const double vertex[] = {40.8, 70.7, 86.6, 86.6}, surface[] = {28.9, 50.0, 70.7, 70.7};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(forces.rows[k].decisive()->value, vertex[k], 0.05) << forces.rows[k].what;
    EXPECT_NEAR(forces.rows[k].readings.front().value, surface[k], 0.05) << forces.rows[k].what;
  }
  EXPECT_EQ(found("5.5").verdict(), Verdict::reproduced);
  EXPECT_EQ(found("5.6").verdict(), Verdict::reproduced);
  const Finding weakest = found("5.7");
  EXPECT_EQ(weakest.verdict(), Verdict::explained) << "5.95 N in place of 6.25 N";
  EXPECT_NEAR(row(weakest, "5.7/mass_30").decisive()->value, 1213.05, 0.01);
  EXPECT_NEAR(row(weakest, "5.7/mass_30").readings.front().value, 1274.2, 0.1) << "with 6.25 N";
  EXPECT_EQ(row(weakest, "5.7/omnidirectional").decisive()->value, 42);
  EXPECT_EQ(row(found("5.8"), "5.8/less").verdict(), Verdict::contradicted) << "-8 % in every set";
  EXPECT_EQ(found("A.2").verdict(), Verdict::contradicted);
  EXPECT_EQ(found("A.4").verdict(), Verdict::contradicted);
}

TEST(Figures, OfChapter6AreWhatIsKnownOfThem) {
  EXPECT_EQ(found("6.1").verdict(), Verdict::reproduced);
  const Finding over_tilt = found("6.4");
  EXPECT_EQ(over_tilt.rows[0].readings[0].value, 0) << "case B is lost, weights on thrusts";
  EXPECT_EQ(over_tilt.rows[1].readings[0].value, 1) << "dynamic weights save it";
  EXPECT_EQ(over_tilt.verdict(), Verdict::reproduced);
  EXPECT_EQ(found("6.3").verdict(), Verdict::contradicted);
}

TEST(Figures, AreAllThereAndFoundByAnyName) {
  std::set<std::string> ids;
  for (const Figure& f : figures()) EXPECT_TRUE(ids.insert(f.id).second) << f.id;
  for (const char* id : {"5.1", "5.8", "6.1", "6.4", "A.1", "A.4", "table 4.1"})
    EXPECT_EQ(ids.count(id), 1u) << id;
  EXPECT_EQ(find_figure("figure a.2"), find_figure("A.2"));
  EXPECT_EQ(find_figure("9.9"), nullptr);
}

TEST(Figures, ThatNeedFlightsSaySoWithoutThem) {
  for (const Figure& f : figures()) {
    EXPECT_EQ(f.fast, f.flights.empty()) << f.id;
    for (const std::string& name : f.flights) EXPECT_NE(find_flight(name), nullptr) << f.id << " " << name;
    if (f.fast) continue;
    const auto found_nothing = f.compute(inputs());
    ASSERT_FALSE(found_nothing) << f.id;
    EXPECT_EQ(found_nothing.error().code, ErrorCode::incomplete) << f.id;
  }
}

TEST(Flights, HaveEachCauseAloneAndAllTogether) {
  for (const char* t : {"t1_", "t2_"}) {
    const Flight* all = find_flight(std::string(t) + "hidden_boards");
    ASSERT_NE(all, nullptr);
    EXPECT_EQ(all->plant, "emulator");
    EXPECT_EQ(all->model, find_flight(std::string(t) + "hidden")->model) << "the same world in both";
    for (const Cause& cause : causes()) {
      const Flight* alone = find_flight(t + std::string(cause.id));
      ASSERT_NE(alone, nullptr) << cause.id;
      EXPECT_NE(all->model.find(cause.effects), std::string::npos) << cause.id;
      EXPECT_NE(alone->model.find(cause.effects), std::string::npos) << cause.id;
    }
    EXPECT_TRUE(find_flight(std::string(t) + "nominal")->model.empty());
  }
}

TEST(Finding, ComesBackFromItsFile) {
  for (const char* id : {"5.1", "5.7", "6.2", "A.2"}) {
    const Finding f = found(id);
    const auto text = to_json(f).dump();
    const auto again = finding_from_json(nlohmann::json::parse(text));
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(to_json(*again).dump(), text) << id;
    EXPECT_EQ(again->verdict(), f.verdict());
  }
}

TEST(Finding, DamagedFilesAreRefusedAndNeverCrash) {
  const auto whole = to_json(found("5.7"));
  for (const auto& [key, value] : whole.items()) {
    auto damaged = whole;
    damaged[key] = 7;
    const bool needed = key != "verdict" && key != "reasons";  // these two follow from the rows
    EXPECT_EQ(bool(finding_from_json(damaged)), !needed) << key;
  }
  auto foreign = whole;
  foreign["rows"][0]["key"] = "9.9/nothing";
  EXPECT_FALSE(finding_from_json(foreign));
  foreign = whole;
  foreign["rows"][0]["chosen"] = 1000;
  EXPECT_FALSE(finding_from_json(foreign));
  EXPECT_FALSE(finding_from_json(nlohmann::json::array()));
}

TEST(Verdicts, FollowFromTheNumbersAlone) {
  Finding f;
  f.rows = {compared("5.7/mass_30", {{"words", 1213.2}})};
  EXPECT_EQ(f.verdict(), Verdict::reproduced);
  f.rows = {compared("5.7/mass_30", {{"words", 1274}, {"other", 1213.2}})};
  EXPECT_EQ(f.verdict(), Verdict::explained);
  EXPECT_NE(f.reasons().at(0).find("other"), std::string::npos);
  f.rows.push_back(compared("5.7/inradius", {{"words", std::nan("")}}));
  EXPECT_EQ(f.verdict(), Verdict::contradicted) << "a number that is none agrees with nothing";
  f.rows = {shown("anything", "m", 3)};
  EXPECT_EQ(f.verdict(), Verdict::unprinted);
}

TEST(Verdicts, OneDefinitionIsTakenForAllRowsOfAFigure) {
  std::vector<Row> rows{compared("A.2/force_30", {{"a", 35}, {"b", 0}}),
                        compared("A.2/force_45", {{"a", 60}, {"b", 0}}),
                        compared("A.2/force_55", {{"a", 0}, {"b", 75}})};
  judge_together(rows);
  EXPECT_EQ(rows[0].verdict(), Verdict::reproduced);
  EXPECT_EQ(rows[2].verdict(), Verdict::contradicted) << "b would suit it, and no other";
}

}  // namespace
}  // namespace omniflight::reproduction
