// Other vehicles that flew beside: told for all recordings, or brought along by one.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Options::neighbours, and every signal "neighbour..." of the recording: positions [m, world], one vehicle
/// each, on its clock. Signals that are no track (not three wide, times not ascending) are left out.
std::vector<physics::NeighbourTrack> neighbours_of(const recording::Recording& recording, const Options& o);

/// The flight's recording brought one along.
bool has_neighbour(const Flight& flight);

}  // namespace omniflight::diagnosis
