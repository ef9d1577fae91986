// Simulation of the rotor drives (command to speed) from recorded commands.
#pragma once

#include <vector>

#include <Eigen/Dense>

#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/actuation.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Command between two samples: zero-order hold or linear interpolation.
enum class Between { held, straight };

/// Whether the effect acts on the drives only (stage actuation, channel rotor_speed), so that rotor commands
/// and speeds suffice to identify it.
bool is_of_drives(const physics::EffectInfo& info);

/// Simulates the drives over `steps` steps of `step` [s] from the initial speeds `start` [rad/s]; time zero
/// is that of the track. `ends` becomes rotors x (steps + 1): speeds [rad/s] at the step boundaries, column 0
/// is `start`. `late_s` [s] is added to the delay of every rotor. Returns false when `actuation` is invalid.
bool simulate_drives(const vehicle::Vehicle& vehicle, physics::Actuation actuation, const CommandTrack& track,
                     Between between, double step, Eigen::Index steps, double late_s,
                     const Eigen::VectorXd& start, Eigen::MatrixXd& ends);

/// Step [s] for simulate_drives(): an eighth of the shortest rotor time constant, within 1 to 2 ms.
double drive_step(const vehicle::Vehicle& vehicle);

}  // namespace omniflight::diagnosis
