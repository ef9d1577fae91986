// The vehicle and what hangs from it as MJCF text.
#pragma once

#include <string>

#include "omniflight_core/result.hpp"
#include "omniflight_proof/world.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

/// Body "vehicle" on a free joint (always the first); "cable_i", "rope_i", "ball", "pod_i", "slosh",
/// "payload" where the world has them, i from 1. Refuses what leaves the body without positive mass or
/// inertia.
Result<std::string> write_mjcf(const vehicle::Vehicle& vehicle, const World& world, const RigidState& start);

/// Centre of the hinge of pod i (0-based) in the body frame [m].
inline Vec3 pod_hinge(const vehicle::Vehicle& vehicle, const FlexibleArms& arms, std::size_t i) {
  return arms.root * vehicle.rotors[i].p_BR;
}

}  // namespace omniflight::proof
