// What a mission's payload and tether put on the simulated vehicle.
#pragma once

#include <vector>

#include "omniflight_core/trajectory.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_planning/mission.hpp"

namespace omniflight::cli {

/// Effects that the plant flies for the mission's payload and tether; empty where it has neither.
///
/// A payload of mass m at r is payload_mass m, com_offset m r / (vehicle's mass) and the diagonal of its
/// inertia; products of inertia, which only a payload off all three axes has, are left out. A tether with
/// mass and its anchor below is hung_cable from the anchor's height on, one from above is overhead_rope, both
/// with the torque of its attachment. Refused: what these effects have no numbers for, and a tether whose
/// attachment passes the height of its anchor.
Result<std::vector<physics::ActiveEffect>> effects_of_loads(const planning::Mission& mission,
                                                            const vehicle::Vehicle& vehicle,
                                                            const std::vector<TrajectoryKnot>& knots);

}  // namespace omniflight::cli
