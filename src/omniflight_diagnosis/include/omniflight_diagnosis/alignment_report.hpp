// Time lags between signals of a recording that measure the same motion.
#pragma once

#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Lag of signal `late` behind signal `early` and its drift, by correlation.
struct Alignment {
  std::string early, late;       ///< signal names
  double lag_s = 0, lag_se = 0;  ///< at `at_s`, with standard error; positive: `late` is later
  double skew = 0, skew_se = 0;  ///< s of lag per s; both 0 below four windows of 5 s
  double correlation = 0;        ///< at that lag
  double at_s = 0;               ///< s, weighted middle of the windows of the skew
};

/// Compares gyro with attitude rate, onboard estimate with measured position, accelerometer with velocity,
/// and rotor speeds with commands and with the accelerometer. One entry for every recorded pair whose
/// correlation exceeds 0.6.
std::vector<Alignment> align_signals(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
