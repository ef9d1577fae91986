// What chapter 5 measures of a set, under each reading of its definition.
#pragma once

#include "omniflight_allocation/wrench_set.hpp"
#include "omniflight_reproduction/figure.hpp"

namespace omniflight::reproduction {

/// Uniformity of forces at zero torque [%]: nearest surface as printed, nearest vertex, their mean.
Result<std::vector<Reading>> force_uniformity(const vehicle::Vehicle& v, double alpha);
/// Uniformity of torques [%]: in every attitude while 1.595 kg is carried (the caption), at zero force, and
/// at an upright thrust of one rotor's limit with drag torque.
Result<std::vector<Reading>> torque_uniformity(const vehicle::Vehicle& v, double alpha);

/// Hulls of forces and torques at several tilts, from above and from the side.
Result<report::Outlines> hulls(const std::vector<std::pair<std::string, vehicle::Vehicle>>& vehicles,
                               const std::vector<double>& alphas, bool torques);

}  // namespace omniflight::reproduction
