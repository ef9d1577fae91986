// A recording without what its loggers and sensors did to it, and what that was.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

struct Repaired {
  recording::Recording recording;  ///< without truth_* signals, copies, frozen and clipped samples; one clock
  std::vector<Window> frozen, clipped;  ///< times that are not to be fitted
  std::vector<SensorFault> faults;      ///< long freezes (stale_samples), far clocks (clock_offset)
  std::vector<std::string> notes;       ///< everything else, in sentences
  std::vector<Alignment> alignment;     ///< as recorded
  bool clock_moved = false;
};

Repaired repaired(const recording::Recording& recording);
/// Of what is judged as it was recorded, or is known to be in order.
Repaired as_it_is(const recording::Recording& recording);

/// As diagnosis and check take a recording: repaired where it carries a wrench, its accelerometer read as if
/// it were at the body's origin.
Repaired in_order(const recording::Recording& recording, const Options& options);

/// prepare_flight() of what has been repaired, or needs no repair.
Result<Flight> prepare_repaired(const Repaired& repaired, const vehicle::Vehicle& vehicle,
                                const Options& options);

}  // namespace omniflight::diagnosis
