// The track of another vehicle, read from a recording of that vehicle.
#pragma once

#include <filesystem>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/neighbour_track.hpp"

namespace omniflight::diagnosis {

/// Track from the signal `position` [m, world] of the recording `path` (in a CSV px_m, py_m, pz_m over t_s).
/// Track times [s] count from `origin` [s] on the absolute clock of that recording (0 for simulated time).
/// `map`: column map of a foreign CSV, or empty. Errors: bad_input naming the file when it cannot be read,
/// has no position, or is not a valid track (physics::validate).
Result<physics::NeighbourTrack> load_neighbour(const std::string& path, const std::filesystem::path& map,
                                               double origin);

}  // namespace omniflight::diagnosis
