// Whether attitude, accelerometer, gyro and velocity are in the conventions that a recording has.
#pragma once

#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Adds an objection when another order of the quaternion, sign, unit or frame fits far better: acceleration
/// against velocity, gyro against attitude, velocity against position. The thrust stands for a missing
/// accelerometer.
void check_conventions(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                       std::vector<std::string>& objections);

}  // namespace omniflight::diagnosis
