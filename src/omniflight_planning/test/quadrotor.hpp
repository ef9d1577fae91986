// An underactuated vehicle that several tests share.
#pragma once

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

/// Four fixed rotors along body z: rank 4.
inline vehicle::Vehicle quadrotor() {
  vehicle::Vehicle v;
  v.name = "quadrotor";
  v.mass = 1.0;
  v.inertia = Vec3(0.008, 0.008, 0.014).asDiagonal();
  for (int k = 0; k < 4; ++k) {
    const double angle = (k + 0.5) * kPi / 2;
    vehicle::Rotor r;
    r.p_BR = 0.17 * Vec3(std::cos(angle), std::sin(angle), 0);
    r.spin = k % 2 == 0 ? 1 : -1;
    r.thrust_coefficient = 5e-6;
    r.drag_ratio = 0.016;
    r.min_thrust = 0.1;
    r.max_thrust = 6.0;
    r.radius = 0.1;
    v.rotors.push_back(r);
  }
  return v;
}

}  // namespace omniflight::planning
