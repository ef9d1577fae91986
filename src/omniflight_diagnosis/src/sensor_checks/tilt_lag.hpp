// How late the measured tilt angle follows its command.
#pragma once

#include <vector>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

struct TiltLags {
  std::vector<double> lag;  ///< s, of every block of some seconds in which the command moves
  double told = 0;          ///< s, lag of the vehicle file that the recorded angle is to show
};

/// First-order lags that leave least between angle and command, behind the rate and, where the recorded angle
/// shows the servo of the vehicle file, its play. Empty where a signal is missing.
TiltLags tilt_lags(const recording::Recording& recording, const vehicle::Tilt& servo, double block_s);

}  // namespace omniflight::diagnosis
