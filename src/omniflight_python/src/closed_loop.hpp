// A flight in this process: plant, sensors, estimator, control law and allocator of the libraries, one after
// the other, on simulated time.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "omniflight_control/controller.hpp"
#include "omniflight_core/trajectory.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_simulation/sensors.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::python {

struct LoopOptions {
  simulation::SensorConfig sensors;
  physics::Environment environment;
  /// Of the control law; empty: for a vehicle that leans what its motors allow, else the law's own.
  std::function<void(control::ControllerConfig&)> gains;
  double hold_s = 2.0;         ///< s at the first reference before, and at the last one after the trajectory
  std::uint64_t seed = 1;      ///< of noise and of effects that are random
  std::function<bool()> stop;  ///< ends it with ErrorCode::incomplete; may be empty
};

/// Flies a trajectory at its tilt. The recording has what a laboratory logs (position, attitude, gyro, acc,
/// rotor_speed, alpha, commands and references) and the truth beside it. Errors: bad_input for a vehicle that
/// cannot hover, incomplete when it leaves its reference by more than 2 m.
Result<recording::Recording> fly(const vehicle::Vehicle& vehicle, const physics::Model& model,
                                 const Trajectory& trajectory, const LoopOptions& options);

}  // namespace omniflight::python
