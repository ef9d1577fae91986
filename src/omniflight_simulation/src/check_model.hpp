// Whether a model can be flown at all: what it leaves of the vehicle, and whether it contradicts itself.
#pragma once

#include "omniflight_simulation/plant.hpp"

namespace omniflight::simulation {

/// Refuses what Plant::create says it refuses of a model. Vehicle, initial state and neighbours are valid.
Status check_model(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config);

}  // namespace omniflight::simulation
