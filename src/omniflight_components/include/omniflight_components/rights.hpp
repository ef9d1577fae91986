// What each role may say and hear on a secured bus.
#pragma once

#include <map>
#include <string>

#include "omniflight_bus/authority.hpp"

namespace omniflight::components {

/// The roles of `omniflight keys`: one a component, "container" for several in one process (the rights of all
/// of them), and "operator" for those who arm, stop and look (hears everything, says wishes alone).
const std::map<std::string, bus::Rights>& rights_of_roles();

}  // namespace omniflight::components
