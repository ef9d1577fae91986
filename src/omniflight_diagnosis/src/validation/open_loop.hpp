// The body flown from recorded rotor speeds alone.
#pragma once

#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// What acts besides the rotors' nominal law.
struct OpenLoopModel {
  Vec3 center_of_mass = Vec3::Zero();  ///< m, of the vehicle file
  std::vector<physics::ActiveEffect> effects = {};
};

/// Advances x from grid sample k of the flight to the next, rotors interpolated, by the midpoint rule in
/// `parts` equal steps. Effects with memory are left out. False when it ran away.
bool advance(const Flight& flight, int k, const OpenLoopModel& model, int parts, RigidState& x);

}  // namespace omniflight::diagnosis
