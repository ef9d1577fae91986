// A vehicle file to start from, of what a log tells of its vehicle.
#pragma once

#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::cli {

struct VehicleDraft {
  std::string yaml;
  std::vector<std::string> told;     ///< what is from the log, and from where in it
  std::vector<std::string> missing;  ///< what is made up, and how to get it
};

/// Rotor count, positions, axes, spins and drag ratios from the autopilot's parameters (or the count from the
/// width of the motor signals); thrust coefficient such that the recorded speeds of slow flight carry the
/// weight, when speeds were logged; the rest made up to scale and named as missing. An error when not even
/// the number of rotors is known.
Result<VehicleDraft> vehicle_from_log(const std::string& name, const recording::Recording& recording);

}  // namespace omniflight::cli
