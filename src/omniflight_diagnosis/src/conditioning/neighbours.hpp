// Tracks of other vehicles during the flight: given for all recordings, or contained in one.
#pragma once

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Options::neighbours, and every signal "neighbour..." of the recording: positions [m, world] on the clock
/// of the recording, one vehicle each. Invalid tracks (not three columns, times not ascending) are left out.
std::vector<physics::NeighbourTrack> neighbours_of(const recording::Recording& recording, const Options& o);

/// Whether the recording contains the track of another vehicle.
bool has_neighbour(const Flight& flight);

}  // namespace omniflight::diagnosis
