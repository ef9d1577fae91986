// Component parameters given by a user or a campaign, before they become YAML.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::cli {

/// Refuses parameters of components that are not in `components` (with the nearest word), values of several
/// lines, and parameters that name the files and devices of the flight itself. Whether a component knows its
/// parameter, it says itself when it is configured.
Status check_parameters(const std::map<std::string, std::string>& parameters,
                        const std::vector<std::string>& components);

}  // namespace omniflight::cli
