// What a mission may ask of a vehicle that leans into its motion.
#pragma once

#include "tilts.hpp"

namespace omniflight::planning {

/// The mission with attitudes in place of headings: upright is the thrust axis of a vehicle with one, else z.
Result<Mission> with_headings(const Mission& mission, const vehicle::Vehicle& vehicle);

/// Refuses a waypoint in whose attitude the vehicle cannot rest, and names the attitude nearest to it in
/// which it can.
Status check_upright(const Waypoint& waypoint, const FlatVehicle& flat, const vehicle::Vehicle& vehicle,
                     bool is_start, const std::string& mission_file);

/// The thrust axis of the legs that move, where they lean into their motion; nothing where the attitude is
/// free. Refuses a mission that has legs of both kinds: one control law flies it.
Result<std::optional<Vec3>> axis_of_motion(const Mission& mission, double alpha, Tilts& tilts);

}  // namespace omniflight::planning
