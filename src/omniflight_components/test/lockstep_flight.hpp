// A short flight of trajectory_1 by OmniMorph, from 1 m on, over the bus in one process.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "omniflight_bus/run_components.hpp"

namespace omniflight::components::test {

/// `more`: further overrides, component:parameter:=value.
inline bus::RunOptions lockstep_flight(int domain, double duration_s, const std::vector<std::string>& more) {
  bus::RunOptions options;
  options.domain = domain;
  options.loopback_file = OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml";
  options.parameter_files = {OMNIFLIGHT_SOURCE_ROOT "/configs/components/default.yaml"};
  options.overrides = {"planner:mission:=trajectory_1", "allocator:vehicle:=omnimorph",
                       "simulator:vehicle:=omnimorph",  "simulator:duration_s:=" + std::to_string(duration_s),
                       "simulator:hold_s:=1",           "simulator:initial_position_m:=[0, 0, 1]"};
  options.overrides.insert(options.overrides.end(), more.begin(), more.end());
  options.timeout = std::chrono::seconds(60);
  options.quiet = true;
  return options;
}

}  // namespace omniflight::components::test
