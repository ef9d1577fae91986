// Lag of the measured tilt angle behind its command.
#pragma once

#include <vector>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

struct TiltLags {
  std::vector<double> lag;  ///< s, one for every block in which the command moves
  double told = 0;  ///< s, lag of the vehicle file; 0 where the recorded angle is an echo of the command
};

/// First-order lags that fit the angle best in blocks of block_s [s], with rate limit and play of `servo`
/// (without play where the angle is an echo of the command). Empty where a signal is missing.
TiltLags tilt_lags(const recording::Recording& recording, const vehicle::Tilt& servo, double block_s);

}  // namespace omniflight::diagnosis
