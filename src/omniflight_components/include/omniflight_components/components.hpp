// Every component by name: what the executables and the container are made of.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "omniflight_bus/component.hpp"

namespace omniflight::components {

/// "simulator", "controller", ... in the order in which a container should start them.
const std::vector<std::string>& component_names();
/// nullptr for an unknown name.
std::unique_ptr<bus::Component> make_component(const std::string& name);

}  // namespace omniflight::components
