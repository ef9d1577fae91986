// Stretches of a flight, and the samples that they are made of.
#pragma once

#include <vector>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Runs of good samples of at least a second.
std::vector<Segment> long_runs(const std::vector<char>& good, double rate_hz);

/// How many samples they hold.
int samples(const std::vector<Segment>& segments);

/// At which of these times [s] the recorded phase says that the vehicle flies freely.
std::vector<char> in_free_flight(const recording::Signal& phase, const std::vector<double>& t);

}  // namespace omniflight::diagnosis
