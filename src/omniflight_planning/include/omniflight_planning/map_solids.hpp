// What pages draw of a mission's map.
#pragma once

#include <vector>

#include "omniflight_planning/mission.hpp"

namespace omniflight::planning {

/// The solids that the test bed's YAML describes; where there is none, the occupied nodes of the octree as
/// boxes, of a depth at which there are at most `most`. The mission's keep-out zones come last, and `zones`
/// of them.
struct MapSolids {
  std::vector<Primitive> solids;
  std::size_t zones = 0;
};
Result<MapSolids> map_solids(const Mission& mission, std::size_t most = 4000);

}  // namespace omniflight::planning
