// Parameters that simulator and emulator share: which vehicle, which effects, which sensors, where it starts.
#pragma once

#include "omniflight_bus/parameters.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_simulation/plant.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::components {

struct PlantParameters {
  vehicle::Vehicle vehicle;
  physics::Model model;
  simulation::SensorConfig sensors;
  simulation::PlantConfig plant;
  std::uint64_t seed = 1;
  double control_period = 0.002;  ///< s between ticks
  double hold = 1.0;              ///< s the body is held at the start
  double duration = 10.0;         ///< s, whole flight
  double peers_timeout = 20.0;    ///< s of wall time to wait for the other components
};

/// Reads and checks them; whatever else the component reads from `p` must be read before p.finish().
Result<PlantParameters> read_plant_parameters(bus::Parameters& p);

/// Makes the plant and its sensors.
Status make_plant(const PlantParameters& parameters, std::optional<simulation::Plant>& plant,
                  std::optional<simulation::SensorSuite>& sensors);

}  // namespace omniflight::components
