// Parameters of control law and allocation, shared by the components and by flights without a bus.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "omniflight_allocation/allocator.hpp"
#include "omniflight_allocation/look_ahead.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_components/loop_parameters.hpp"

namespace omniflight::components {

/// Reads and checks the law's parameters of the controller; whatever else the component has is read beside.
LawParameters read_law_parameters(bus::Parameters& p);
/// That the law is known and may be used so; the law itself.
Result<std::unique_ptr<control::Law>> make_law(const LawParameters& parameters);

/// Reads and checks all parameters of the allocator, p.finish() included, and loads its vehicle and schedule.
Result<AllocatorParameters> read_allocator_parameters(bus::Parameters& p);

}  // namespace omniflight::components
