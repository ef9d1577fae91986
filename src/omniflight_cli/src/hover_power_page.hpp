// `design --hover-power`: what hovering costs in every attitude at every tilt.
#pragma once

#include <nlohmann/json.hpp>

#include "omniflight_allocation/hover_power.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {

/// Leans of 0 to 180 deg in steps of 15, tilts of the vehicle in steps of 5 deg, 24 azimuths: the most
/// expensive of them.
Result<allocation::HoverMap> hover_power_map(const vehicle::Vehicle& vehicle);

/// Attitudes with a lean of 90 deg that at most half of the rotors carry, at their cheapest tilt: a line
/// each.
Result<std::vector<std::string>> half_carried(const vehicle::Vehicle& vehicle,
                                              const allocation::HoverMap& map);

nlohmann::json hover_power_json(const allocation::HoverMap& map,
                                const std::vector<std::string>& half_carried);
void hover_power_section(const allocation::HoverMap& map, const std::vector<std::string>& half_carried,
                         report::Page& page);

}  // namespace omniflight::cli
