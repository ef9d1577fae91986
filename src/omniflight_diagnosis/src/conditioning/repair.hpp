// Repair of a recording: duplicated, frozen and clipped samples, clock offsets, lever arm of the
// accelerometer.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

struct Repaired {
  recording::Recording recording;       ///< repaired, without truth_* signals
  std::vector<Window> frozen, clipped;  ///< windows to exclude from fits
  std::vector<SensorFault> faults;      ///< long freezes (stale_samples), clock offsets (clock_offset)
  std::vector<std::string> notes;       ///< all other repairs, as sentences
  std::vector<Alignment> alignment;     ///< lags before the correction
  bool clock_moved = false;
};

/// Removes duplicated, frozen and clipped samples and corrects clocks. A recording with signals of the wrong
/// width or values that are not finite is returned without truth_* signals but unrepaired; validate_input()
/// refuses it.
Repaired repaired(const recording::Recording& recording);
/// The recording without any repair.
Repaired as_it_is(const recording::Recording& recording);

/// The input of diagnose() and check(): repaired where the recording allows a wrench analysis, and with the
/// accelerometer corrected to the body origin (Options::imu_position).
Repaired in_order(const recording::Recording& recording, const Options& options);

/// prepare_flight() without the repair.
Result<Flight> prepare_repaired(const Repaired& repaired, const vehicle::Vehicle& vehicle,
                                const Options& options);

}  // namespace omniflight::diagnosis
