// The track of another vehicle, out of any recording of it.
#pragma once

#include <filesystem>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/neighbour_track.hpp"

namespace omniflight::diagnosis {

/// Reads where the vehicle of a recording was: its signal `position` (in a CSV px_m, py_m, pz_m over t_s).
/// The times [s] of the track begin at `origin` [s] of the recording's clock, 0 for simulated time. `map`: of
/// the columns of a foreign CSV, or empty. Errors: bad_input naming the file, when it cannot be read, has no
/// position, or is no track.
Result<physics::NeighbourTrack> load_neighbour(const std::string& path, const std::filesystem::path& map,
                                               double origin);

}  // namespace omniflight::diagnosis
