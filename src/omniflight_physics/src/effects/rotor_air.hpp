// The air of a rotor, as the inflow effects share it: at a given speed the thrust answers a change dw of the
// air velocity through the disc by -k_z |Omega| dw, with one coefficient k_z [kg/rad] whatever blows (blade
// element theory, linear in the inflow; RotorPy's k_z, and PX4's thrust (1 - v/25 m/s) linearised).
#pragma once

#include <cmath>

#include "omniflight_physics/situation.hpp"

namespace omniflight::physics {

/// +1 or -1: which way along n the rotor pushes the vehicle.
inline double thrust_sign(const RotorSituation& r) { return r.thrust < 0 ? -1.0 : 1.0; }

/// Induced velocity [m/s] of momentum theory in hover, sqrt(|T| / (2 rho pi R^2)).
inline double hover_induced_velocity(const RotorSituation& r, double air_density) {
  if (!(r.radius > 0)) return 0.0;
  return std::sqrt(std::abs(r.thrust) / (2.0 * air_density * kPi * r.radius * r.radius));
}

/// Velocity [m/s, body axes] of a hub through air at rest.
inline Vec3 hub_velocity(const Situation& s, const RotorSituation& r) {
  return s.v_WB_B + s.body.w_WB_B.cross(r.p_BR);
}

/// Position [m] of a hub in the world.
inline Vec3 hub_position(const Situation& s, const RotorSituation& r) {
  return s.body.p_WB + s.R_WB * r.p_BR;
}

}  // namespace omniflight::physics
