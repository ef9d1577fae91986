// Open-loop simulation of the body from recorded rotor speeds.
#pragma once

#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// Model besides the nominal rotors.
struct OpenLoopModel {
  Vec3 center_of_mass = Vec3::Zero();  ///< m, of the vehicle file
  std::vector<physics::ActiveEffect> effects = {};
};

/// Integrates x from grid sample k to k + 1 with `parts` steps of the midpoint rule, rotors interpolated.
/// Effects with memory are ignored. Returns false when the state is not finite.
bool advance(const Flight& flight, int k, const OpenLoopModel& model, int parts, RigidState& x);

}  // namespace omniflight::diagnosis
