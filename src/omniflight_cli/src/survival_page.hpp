// `design --survival`: which way of choosing weights and tilt survives a full roll, and at what power.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "omniflight_allocation/survival.hpp"
#include "omniflight_report/page.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

/// Schema omniflight.survival/1.
nlohmann::json survival_json(const std::string& vehicle, const allocation::SurvivalMap& map);

/// For the terminal: a line a method, and how both kinds of look-ahead compare with case A.
std::vector<std::string> survival_lines(const allocation::SurvivalMap& map);

report::Page survival_page(const std::string& vehicle, const allocation::SurvivalMap& map);

/// Flies the map of a vehicle and writes survival.json and report.html where --out is given.
Result<int> map_survival(const vehicle::Vehicle& vehicle, const Common& common);

}  // namespace omniflight::cli
