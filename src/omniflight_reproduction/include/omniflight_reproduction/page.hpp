// All figures on one page, the conclusion first.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_reproduction/figure.hpp"

namespace omniflight::reproduction {

/// What came of one figure.
struct Computed {
  const Figure* figure = nullptr;
  std::optional<Finding> finding;  ///< nothing: not computed
  std::string why_not;             ///< then the reason
  double seconds = 0;              ///< that its computation took, flights not counted
  bool kept = false;               ///< of an earlier run with the same inputs
};

/// "21 figures: 9 reproduced, ..." over those asked for.
std::string conclusion(const std::vector<Computed>& all);
/// Schema omniflight.reproduction/1.
nlohmann::json to_json(const std::vector<Computed>& all, const std::string& version);
/// remarks: what the reader has to know of this run, a paragraph each.
Status write_page(const std::vector<Computed>& all, const std::string& version,
                  const std::vector<std::string>& remarks, const std::string& path);

}  // namespace omniflight::reproduction
