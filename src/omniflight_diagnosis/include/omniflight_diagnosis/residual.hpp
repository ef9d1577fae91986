// What the nominal vehicle does not explain, at one instant: the same for recordings and in flight.
#pragma once

#include "omniflight_physics/situation.hpp"

namespace omniflight::diagnosis {

/// Force [N] and torque [Nm] about the body origin, body axes, that the nominal rotors do not explain:
/// rho_F = m f - sum T_i n_i, rho_tau = J dw + w x J w + c x m f - rotor torque.
/// specific_force [m/s^2, body] is what an accelerometer at the body origin reads; s carries w and dw.
Vec6 wrench_residual(const physics::Situation& s, const Vec3& specific_force, const Vec3& center_of_mass);

/// What an accelerometer at p_BI [m, body] reads beside one at the origin [m/s^2, body].
inline Vec3 beside_origin(const Vec3& p_BI, const Vec3& w, const Vec3& dw) {
  return dw.cross(p_BI) + w.cross(w.cross(p_BI));
}

/// Speed [rad/s] of a rotor dt [s] later under a constant command, first-order lag with this time constant
/// [s]; a time constant of 0 follows at once.
inline double lagged_speed(double speed, double command, double time_constant, double dt) {
  const double keep = time_constant > 0 ? std::exp(-dt / time_constant) : 0.0;
  return keep * speed + (1 - keep) * command;
}

}  // namespace omniflight::diagnosis
