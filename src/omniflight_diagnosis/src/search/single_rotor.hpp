// An effect that has numbers for every rotor, restricted to one of them: what is usually broken is one rotor.
#pragma once

#include <vector>

#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// The candidates, each effect that describes rotors one by one replaced by its restrictions to one rotor: of
/// several rotors each is a member of its own. Effects that act on the wrench where no signal shows them
/// (Effect::unrecorded_form) follow the first of their aliases.
std::vector<const physics::Effect*> by_rotor(const std::vector<const physics::Effect*>& candidates,
                                             const vehicle::Vehicle& vehicle);

/// The same as an effect of the library, all other rotors at their neutral values.
physics::ActiveEffect in_full(const physics::ActiveEffect& active);

}  // namespace omniflight::diagnosis
