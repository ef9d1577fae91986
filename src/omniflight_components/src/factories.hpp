// One factory a component; the table in components.cpp lists them.
#pragma once

#include <memory>

#include "omniflight_bus/component.hpp"

namespace omniflight::components {

std::unique_ptr<bus::Component> make_recorder();
std::unique_ptr<bus::Component> make_planner();
std::unique_ptr<bus::Component> make_controller();
std::unique_ptr<bus::Component> make_allocator();
std::unique_ptr<bus::Component> make_simulator();
std::unique_ptr<bus::Component> make_emulator();
std::unique_ptr<bus::Component> make_gateway();
std::unique_ptr<bus::Component> make_monitor();
std::unique_ptr<bus::Component> make_natnet();
std::unique_ptr<bus::Component> make_natnet_emulator();

}  // namespace omniflight::components
