// Judged cases by family, vehicle, flight, level and effect: rates with Wilson intervals, calibration of what
// was said.
#pragma once

#include <nlohmann/json.hpp>

#include "family_judge.hpp"

namespace omniflight::proof {

struct Rate {
  int k = 0, n = 0;
  void count(bool good) { ++n, k += good; }
  double value() const { return n > 0 ? static_cast<double>(k) / n : std::nan(""); }
};

/// Scores of some of the cases.
struct GroupScores {
  std::string axis, value;  ///< "vehicle", "quadrotor_37g"
  Rate alarms;              ///< of nominal flights
  Rate detected, stage, top1,
      covered;  ///< of hidden effects; top1 and covered of single ones that a library has
  Rate pairs, triples, unknown, intervals, unanswered;
  double set_size = 0;   ///< mean over answers with findings
  double log_score = 0;  ///< mean -ln of the probability of what is so, at most kWorstLog
  int cases = 0;
};
inline constexpr double kWorstLog = 4.605;  ///< ln 100: a probability below 1 % counts as 1 %

/// One line of the table with must and goal.
struct FamilyLine {
  std::string name = {}, over = {};
  Rate rate = {};
  bool is_rate = true;
  double value = 0;
  double must = 0, goal = 0;
  bool smaller = false;   ///< is better
  double upper_must = 1;  ///< of a rate that must not be too high either
  std::string verdict() const;
};

struct Reliability {
  struct Bin {
    double low = 0, high = 0, stated = 0;
    Rate came_true;
  };
  std::vector<Bin> bins;
  double expected_error = 0;  ///< mean |stated - came true|, by the number of statements
  int statements = 0;
};

struct RiskPoint {
  double answered = 0, accuracy = 0, confidence = 0;
};

struct FamilyScores {
  std::vector<FamilyLine> lines;
  std::vector<GroupScores> groups;  ///< the first is all
  Reliability reliability;
  std::vector<RiskPoint> risk;  ///< the surest answers first
  std::vector<FamilyJudged> cases;
};

FamilyScores score_families(const std::vector<FamilyCase>& truths,
                            const std::map<std::string, Answer>& answers);

nlohmann::json to_json(const FamilyScores& scores);
std::string to_text(const FamilyScores& scores);
Status write_family_report(const FamilyScores& scores, const std::string& headline,
                           const std::filesystem::path& file);

}  // namespace omniflight::proof
