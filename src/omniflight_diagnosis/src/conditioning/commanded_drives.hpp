// Speeds that the rotors' drives reach from recorded commands.
#pragma once

#include <vector>

#include <Eigen/Dense>

#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/actuation.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// What a command does between two samples.
enum class Between { held, straight };

/// Whether the library says that an effect is seen in commands and speeds of the rotors, and in nothing else.
bool is_of_drives(const physics::EffectInfo& info);

/// Speeds [rad/s] at the ends of `steps` steps of `step` seconds, column 0 the start, rotors x (steps + 1),
/// of drives that begin with the speeds `start`; the first step begins at time zero of the track. `late_s`:
/// added to every rotor's delay. False for drives that cannot be.
bool simulate_drives(const vehicle::Vehicle& vehicle, physics::Actuation actuation, const CommandTrack& track,
                     Between between, double step, Eigen::Index steps, double late_s,
                     const Eigen::VectorXd& start, Eigen::MatrixXd& ends);

/// Step [s] of such a simulation that resolves the lag of a vehicle's rotors.
double drive_step(const vehicle::Vehicle& vehicle);

}  // namespace omniflight::diagnosis
