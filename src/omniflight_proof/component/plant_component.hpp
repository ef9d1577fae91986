#pragma once

#include <memory>

#include "omniflight_bus/component.hpp"

namespace omniflight::proof {

/// The component "mujoco_plant": clock master of a flight, exchangeable with the simulator. Parameters: those
/// of the simulator, with `world` (file, omniflight.proof_world/1) in the place of `model`.
std::unique_ptr<bus::Component> make_plant_component();

}  // namespace omniflight::proof
