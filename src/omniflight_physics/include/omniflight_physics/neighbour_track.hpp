// Where another multirotor was, over time: told beside a recording, or set for a simulation.
#pragma once

#include <span>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/situation.hpp"

namespace omniflight::physics {

struct NeighbourTrack {
  std::vector<double> t_s;  ///< s, ascending; one sample: it hovers there all the time
  std::vector<Vec3> p_WN;   ///< m, world; as many
};

/// Refuses a track that is empty, not ascending, not finite or of two lengths.
Status validate(const NeighbourTrack& track);

/// Fills the neighbours of the situation at time t [s], linear between samples; one whose track does not
/// cover t is absent. At most kMaxNeighbours are used, the first ones. Allocates nothing.
void set_neighbours(std::span<const NeighbourTrack> tracks, double t, Situation& situation);

}  // namespace omniflight::physics
