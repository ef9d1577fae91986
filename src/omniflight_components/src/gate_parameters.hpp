// The gateway's parameters of its safety gate.
#pragma once

#include <algorithm>

#include "omniflight_bus/parameters.hpp"
#include "omniflight_gateway/safety_gate.hpp"

namespace omniflight::components {

/// Rotors and their largest speed come from the vehicle.
inline gateway::GateConfig read_gate(bus::Parameters& p, double period_s) {
  gateway::GateConfig gate;
  gate.stale_after_s = p.number("stale_after_s", 0.1, 0.005, 2.0);
  const double fresh_s = std::min(gate.stale_after_s, std::max(period_s, 0.01) + 0.005);
  gate.fresh_for_s = p.number("fresh_for_s", fresh_s, 0.005, 2.0);
  gate.own_sleep_s = std::max(gate.own_sleep_s, 4 * period_s);
  gate.ramp_s = p.number("ramp_s", 0.5, 0.01, 10);
  gate.max_acceleration_radps2 = p.number("max_rotor_acceleration_radps2", 1e5, 1, 1e8);
  return gate;
}

}  // namespace omniflight::components
