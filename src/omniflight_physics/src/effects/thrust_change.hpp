// A change of the thrust of one rotor and the wrench that follows from it.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

/// Adds dT [N] along the axis of a rotor, with its arm and its reaction torque.
template <class T>
void add_thrust(const RotorSituation& r, const T& dT, WrenchT<T>& out) {
  out.force_B += dT * r.n_B.cast<T>();
  out.torque_B += dT * Vec3(r.p_BR.cross(r.n_B) + r.spin * r.drag_ratio * r.n_B).cast<T>();
}

}  // namespace omniflight::physics
