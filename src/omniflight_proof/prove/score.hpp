// From truth and answers to the table of scores. Must and goal stand in the code and are printed beside what
// came out; nothing here knows which of them are met when it counts.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "case_truth.hpp"
#include "score_answer.hpp"
#include "score_stats.hpp"

namespace omniflight::proof {

/// One line of the table: a rate (k of n) or a number.
struct Score {
  std::string name = {};  ///< "right effect, top-1"
  std::string over = {};  ///< which cases, in words
  int k = 0, n = 0;       ///< of a rate; n == 0: nothing to judge
  bool is_rate = true;
  double value = 0;        ///< rate, or the number
  Interval interval = {};  ///< of a rate
  std::string unit = {};   ///< of a number
  std::string must = {}, goal = {};
  enum class Verdict { goal, must, short_of, not_judged, information } verdict = Verdict::information;
};
std::string to_string(Score::Verdict verdict);

/// How one case was judged.
struct Judged {
  std::string id, kind, level, flight, magnitude, verdict, why;
  std::string truth, said;    ///< as judged: aliases of a flight merged under one name
  std::string hidden, named;  ///< the same before merging
  bool alarm = false, detected = false, stage = false, top1 = false, covered = false, exact = false;
  bool refused = false;  ///< no answer, or "unusable"
  int set_size = 0;
  double explained = 0;  ///< share of the removable held-out energy, NaN when not judged
  double badness = 0;    ///< for sorting: how wrong
};

struct Scores {
  std::vector<Score> table;
  std::vector<Judged> cases;
  std::map<std::string, std::map<std::string, int>> confusion;  ///< truth -> first answer -> count
};

/// One case against its answer.
Judged judge(const Truth& truth, const Answer& answer);
/// All of them. Answers are by case id; a missing one counts as not given.
/// second: answers from the first flight and the proposed one together, where one was proposed and flown.
/// oracle: fits that were told what is hidden; with them it is counted, too, what was found of that which
/// such a fit sees at all. Information beside the must, which counts every case.
/// last_asked: the last case whose proposed flight was asked for; empty for all.
Scores score(const std::vector<Truth>& truths, const std::map<std::string, Answer>& answers,
             const std::map<std::string, Answer>& second = {},
             const std::map<std::string, Answer>& oracle = {}, const std::string& last_asked = {});

/// An answer without what is really there besides the hidden effects: naming a nuisance is no error.
Answer without_nuisances(const Truth& truth, Answer answer);

}  // namespace omniflight::proof
