// Thrusts whose rotors stand at another tilt than the one that is known.
#pragma once

#include "omniflight_physics/situation.hpp"

namespace omniflight::physics {

/// Adds what changes when every tilting rotor is turned by `angle` [rad] about its tilt axis beyond s.alpha:
/// dF = sum T_i dn_i, dM = sum T_i (r_i x dn_i + kappa s_i dn_i), exact.
template <class T>
void add_turned_rotors(const Situation& s, const T& angle, WrenchT<T>& out) {
  using std::cos;
  using std::sin;
  const T turned = sin(angle), left = cos(angle) - T(1);
  for (const RotorSituation& r : s.all_rotors()) {
    const Vec3& t = r.tilt_axis_B;
    if (t.isZero()) continue;
    const Vec3 across = t.cross(r.n_B), radial = r.n_B - t.dot(r.n_B) * t;
    const Eigen::Matrix<T, 3, 1> f = T(r.thrust) * (turned * across.cast<T>() + left * radial.cast<T>());
    out.add_at(r.p_BR, f);
    out.torque_B += T(r.spin * r.drag_ratio) * f;
  }
}

}  // namespace omniflight::physics
