// How well the clocks of a recording's signals agree.
#pragma once

#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Signal `late` against `early`: lag at the middle of the recording, and how it drifts.
struct Alignment {
  std::string early, late;       ///< signal names
  double lag_s = 0, lag_se = 0;  ///< positive: `late` comes later than `early`
  double skew = 0, skew_se = 0;  ///< s of lag gained a second; 0 and 0 when the flight is too short
  double correlation = 0;
  double at_s = 0;  ///< middle of what the skew was measured on
};

/// Gyro against the rates of the attitudes, the vehicle's own estimate against the position, accelerometer
/// against the velocities, rotor speeds against commands and against the accelerometer: every pair that was
/// recorded and moves enough to tell.
std::vector<Alignment> align_signals(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
