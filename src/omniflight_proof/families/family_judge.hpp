// One case of a families run against its answer. Reads nothing of an answer but the fields of the contract,
// so that any two analyses can be compared on the same cases.
#pragma once

#include <map>

#include "family.hpp"
#include "score.hpp"

namespace omniflight::proof {

/// What an answer said with which probability, and whether it was so.
struct Statement {
  double probability = 0;
  bool true_one = false;
};

struct FamilyJudged {
  const FamilyCase* truth = nullptr;
  bool given = false;    ///< an answer that can be judged: not missing, unusable or unfinished
  bool nominal = false;  ///< nothing is hidden
  bool alarm = false;    ///< anything but nothing_missing
  bool stage = false, top1 = false, covered = false, exact = false;
  bool unknown_right = false;   ///< called unknown, right stage and first variable
  double set_size = 0;          ///< mean over the findings; 0 without
  double confidence = 0;        ///< that the answer states for what it says first
  double true_probability = 0;  ///< that it gives to what is so
  int intervals = 0, intervals_hold = 0;
  std::vector<double> parameter_errors;  ///< relative
  std::vector<Statement> statements;
  std::string hidden, said, verdict, why;
  bool right() const { return nominal ? !alarm : top1; }
};

FamilyJudged judge(const FamilyCase& truth, const Answer& answer);

}  // namespace omniflight::proof
