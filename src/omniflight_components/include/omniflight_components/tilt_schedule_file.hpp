// The file of a tilt over time that the allocator follows: omniflight.tilt_schedule/1.
#pragma once

#include <filesystem>
#include <string>

#include "omniflight_allocation/look_ahead.hpp"

namespace omniflight::components {

/// YAML: period_s [s], alpha_deg [deg], one a period of trajectory time.
std::string tilt_schedule_text(const allocation::TiltSchedule& schedule);

/// Refuses what is not such a file, periods outside [0.001, 10] s, tilts outside the limits of the vehicle,
/// and tilts that move faster than its servo; errors name file, field and unit.
Result<allocation::TiltSchedule> read_tilt_schedule(const std::filesystem::path& path,
                                                    const vehicle::Tilt& tilt);

}  // namespace omniflight::components
