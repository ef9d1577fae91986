// What values of an effect make sense on this vehicle: the catalogue's bounds are wide enough for any.
#pragma once

#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Natural sizes of a vehicle that hovers.
struct VehicleScale {
  double weight = 1;                        ///< N
  double arm = 1;                           ///< m, largest distance of a rotor
  double disc = 1;                          ///< m2, of a circle around all rotors
  double rotor_thrust = 1;                  ///< N, of one rotor in hover
  double rotor_speed = 1;                   ///< rad/s, in hover
  double speed_sum = 1;                     ///< rad/s, of all rotors
  double inertia_min = 1, inertia_max = 1;  ///< kg m2, principal
  Mat3 inertia = Mat3::Identity();
  double mass = 1;
  double highest = -1e18;           ///< m, where its frame has been
  double least_drag_torque = -0.6;  ///< 1, of drag_torque_scale; noisy torques of rotors pull it towards -1
};
VehicleScale scale_of(const vehicle::Vehicle& vehicle, double gravity);

struct Range {
  double lower = -1e18, upper = 1e18;
};

/// A regression bends any law into what the flight shows: rotors moved by half an arm so that noisy thrusts
/// count less, or a thrust curve whose two terms cancel. Beyond this range it is not this effect that the
/// flight shows. Already within the catalogue's bounds.
Range plausible_range(const physics::Effect& effect, std::size_t parameter, const VehicleScale& scale);

/// Values that each make sense but not together, or not with the flight: a rope that damps and does not pull,
/// a ceiling below the vehicle, a friction that grows with speed, a torsion about half a turn away.
bool contradicts_itself(const physics::ActiveEffect& effect, const VehicleScale& scale);

}  // namespace omniflight::diagnosis
