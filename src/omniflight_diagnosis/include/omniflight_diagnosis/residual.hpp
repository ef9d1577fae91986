// Wrench residual of the nominal vehicle at one instant, shared by diagnosis and monitoring.
#pragma once

#include "omniflight_physics/situation.hpp"

namespace omniflight::diagnosis {

/// Measured minus nominal wrench [N, Nm], body axes, torque about the body origin. With the specific force
/// f_c = f + dw x c + w x (w x c) of the centre of mass c: force m f_c - sum T_i n_i, torque J dw + w x J w +
/// m c x f_c - rotor torques (J about the centre of mass). specific_force f [m/s^2, body] is what an
/// accelerometer at the body origin reads, center_of_mass [m, body]; w, dw, mass, inertia and rotors are
/// those of `s`.
Vec6 wrench_residual(const physics::Situation& s, const Vec3& specific_force, const Vec3& center_of_mass);

/// Lever-arm acceleration [m/s^2, body]: reading of an accelerometer at p_BI [m, body] minus that of one at
/// the body origin, at rate w [rad/s] and angular acceleration dw [rad/s^2].
inline Vec3 beside_origin(const Vec3& p_BI, const Vec3& w, const Vec3& dw) {
  return dw.cross(p_BI) + w.cross(w.cross(p_BI));
}

/// Rotor speed [rad/s] after dt [s] of a constant command [rad/s], first-order lag with this time constant
/// [s]. A time constant of 0 means no lag.
inline double lagged_speed(double speed, double command, double time_constant, double dt) {
  const double keep = time_constant > 0 ? std::exp(-dt / time_constant) : 0.0;
  return keep * speed + (1 - keep) * command;
}

}  // namespace omniflight::diagnosis
