// A rigid load on the vehicle: its weight and inertia in what the rotors give.
#pragma once

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

/// Counts as a point mass; its shape belongs to the vehicle's collision shapes.
struct Payload {
  double mass = 0.0;        ///< kg
  Vec3 p_B = Vec3::Zero();  ///< m, its centre of mass in the body frame
};

/// The vehicle with a point mass: mass, centre of mass and inertia about that (parallel axes).
vehicle::Vehicle carrying(const vehicle::Vehicle& vehicle, const Payload& payload);

}  // namespace omniflight::planning
