// A set of flights as a file describes it: the product of missions, vehicles, effects, variants and seeds,
// and what is expected of them.
#pragma once

#include "flight.hpp"
#include "omniflight_campaign/vary.hpp"
#include "verdict.hpp"

namespace omniflight::cli {

struct Case {
  std::string name;  ///< also its folder
  std::string mission, effect, variant;
  FlightOptions options;
};

/// What should come out, so that a campaign answers its own question.
struct Expectation {
  std::string variant, effect, mission;  ///< empty: any
  std::string verdict = "flown";         ///< flown | flown_badly | survived (one of both) | lost
  bool met_by(const std::string& flight) const {
    if (verdict == "survived") return flight == kFlown || flight == kFlownBadly;
    return flight == verdict;
  }
  bool covers(const Case& one) const {
    const auto is = [](const std::string& asked, const std::string& has) {
      return asked.empty() || asked == has;
    };
    return is(variant, one.variant) && is(effect, one.effect) && is(mission, one.mission);
  }
};

struct Campaign {
  std::string name, question;
  std::vector<Case> groups;  ///< what flights with other seeds have in common; the seed is none's
  std::vector<std::uint64_t> seeds;
  std::vector<Case> cases;               ///< groups times seeds; empty where they are not flown one by one
  std::vector<campaign::Varied> varied;  ///< drawn anew for every seed
  std::vector<Expectation> expected;
  int more_flights = -1;  ///< of the investigation of each flown case at most; -1: none is made
};

/// How the flights of a campaign are flown.
enum class Flying {
  bus,         ///< each by itself, with components, sensors and a recording
  in_process,  ///< many at once without: see omniflight_campaign/many_flights.hpp
};
/// Reads omniflight.campaign/1. Refuses unknown keys, names nobody has, more than 10000 flights over the bus
/// and 1000000 in process, and what that way of flying has not.
Result<Campaign> load_campaign(const std::string& path, Flying flying = Flying::bus);

/// What came of one case.
struct Outcome {
  Case flight;
  std::string verdict, reason;  ///< verdict empty: not flown (interrupted)
  nlohmann::json json;          ///< flight.json
  std::string investigation;    ///< what was found, in words; empty: nobody asked
  std::string cause;            ///< what every flight says together, when one answer is left
  std::size_t flights = 0;      ///< after which it was
  bool flown() const { return verdict == kFlown; }
  bool survived() const { return flown() || verdict == kFlownBadly; }
};

/// How many flights of a group ended with a verdict.
struct Tally {
  const Case* group = nullptr;
  std::string verdict;  ///< empty: not flown
  std::size_t flights = 0;
};

/// How an expectation was met.
struct Judgement {
  Expectation expected;
  std::size_t flights = 0, as_expected = 0;
  bool rest = false;  ///< over the flights that no expectation of the file covers
  bool met() const { return flights > 0 && as_expected == flights; }
  std::string words() const;  ///< "case_b with tilt_mismatch: lost, as expected (1 of 1 flights)"
};
/// Without `expect` every flight is expected to be flown; with it, every flight that no entry covers.
std::vector<Judgement> judge(const Campaign& campaign, const std::vector<Tally>& tallies);
std::vector<Judgement> judge(const Campaign& campaign, const std::vector<Outcome>& outcomes);
/// One sentence over all judgements; empty without expectations.
std::string verdict_in_words(const std::vector<Judgement>& judgements);
/// "2 of 4 flights flown, 1 flown badly, 1 lost", of the verdicts that are there.
std::string flown_in_words(const std::vector<std::string>& verdicts, std::size_t planned);
/// The first line of a page: whether everything ended as expected, and what did not first.
std::string headline(const std::vector<Judgement>& judgements, std::size_t not_flown);
/// As campaign.json lists them.
nlohmann::json to_json(const std::vector<Judgement>& judgements);

/// A number out of flight.json, NaN when it is not there; true state where there is one, else as measured.
double figure(const nlohmann::json& flight, const std::string& pointer_below_tracking);
/// m, over the three axes.
double position_rmse(const nlohmann::json& flight);

/// Ranks and compares: out/report.html. Reads the recordings below `out` for its plots.
Status write_campaign_page(const Campaign& campaign, const std::vector<Outcome>& outcomes,
                           const std::vector<Judgement>& judgements, const std::string& out);

}  // namespace omniflight::cli
