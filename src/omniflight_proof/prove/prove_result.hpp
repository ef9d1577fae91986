// proof.json and the report page of a campaign.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "score.hpp"
#include "score_leak.hpp"

namespace omniflight::proof {

inline constexpr const char* kWhole = "nothing left out";  ///< among the ablations

struct ProofResult {
  Scores scores;
  std::map<std::string, Scores> baselines;  ///< by name
  std::map<std::string, Scores> ablations;  ///< by name, and "nothing left out": all on the same cases
  LeakResult leak;                          ///< which effect is hidden
  LeakResult leak_whether;                  ///< whether any is
  nlohmann::json commitment, probe;
  std::string truth_sha256, answers_sha256, answers_next_sha256, ablations_sha256, salt, box;
  double analysis_s = 0;  ///< wall time of all diagnoses together
  double longest_s = 0;
  double median_s = 0;
};

/// schema omniflight.proof/1.
nlohmann::json to_json(const ProofResult& result);
Status write_report(const ProofResult& result, const std::filesystem::path& file);

}  // namespace omniflight::proof
