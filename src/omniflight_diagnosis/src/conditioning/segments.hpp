// Segments of usable samples.
#pragma once

#include <vector>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Runs of good samples of at least 1 s.
std::vector<Segment> long_runs(const std::vector<char>& good, double rate_hz);

/// Number of samples in all segments.
int samples(const std::vector<Segment>& segments);

/// Flags of the times t [s] at which the recorded phase is 1: free flight.
std::vector<char> in_free_flight(const recording::Signal& phase, const std::vector<double>& t);

}  // namespace omniflight::diagnosis
