// What an analysis said about a case, read from its diagnosis.json; nothing in the file is trusted.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::proof {

struct AnsweredParameter {
  std::string name;
  double value = 0, low = 0, high = 0;
};
struct AnsweredEffect {
  std::string id, stage;
  double probability = 0;
  std::vector<std::string> set;  ///< the effect and everything it cannot be told apart from
  std::vector<AnsweredParameter> parameters;
};
struct AnsweredUnknown {
  std::string stage;
  std::vector<std::string> variables;
};
/// Before and after of one channel; for the closed loop: recorded, nominal, with the model.
struct AnsweredChannel {
  std::string channel;
  double before = 0, after = 0, real = 0;
};

struct Answer {
  bool given = false;        ///< there is a readable answer
  std::string verdict = {};  ///< of the contract
  std::string problem = {};  ///< why there is none
  std::vector<AnsweredEffect> findings = {};
  std::vector<AnsweredUnknown> unknown = {};
  std::vector<std::string> mismatch_stages = {};
  std::vector<AnsweredChannel> held_out = {}, closed_loop = {};
  double power_real = 0, power_after = 0;  ///< W, 0 when not flown again
  bool proposes = false;                   ///< a next flight
  double runtime = 0;                      ///< s
};

/// Reads schema omniflight.diagnosis/1. A field of the wrong type makes it an answer that is not given.
Answer read_answer(std::string_view text);

/// Several words for one thing: "height", "h", "pz" are all "height". Unknown words stay.
std::string plain_variable(const std::string& word);

}  // namespace omniflight::proof
