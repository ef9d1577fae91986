// What `diagnose --check` says of one recording.
#pragma once

#include <vector>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

/// Signals with their rates and where in the log they come from, whether its motors are in the vehicle's
/// order, clocks, motion, sensors, and what is missing. `recordings` are searched for the one that is
/// described.
void say_intake(const Common& common, const diagnosis::Intake& in, const vehicle::Vehicle& vehicle,
                const std::vector<recording::Recording>& recordings);

}  // namespace omniflight::cli
