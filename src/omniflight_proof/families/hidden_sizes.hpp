// How large errors of sensors are.
// Sizes are formulas where an error moves nothing: what the wrong reading looks like as a force or torque, or
// the error over the noise of the same sensor.
#pragma once

#include "hidden.hpp"

namespace omniflight::proof {

using Measure = Hidden::Measure;

inline SensorSize forces(double each, double torque = 0) {
  SensorSize s;
  for (std::size_t c = 0; c < 3; ++c) s.wrench[c] = each, s.wrench[c + 3] = torque;
  return s;
}
inline SensorSize along(const Vec3& force) {
  SensorSize s;
  for (std::size_t c = 0; c < 3; ++c) s.wrench[c] = std::abs(force[static_cast<int>(c)]);
  return s;
}
inline SensorSize own(double sigma) {
  SensorSize s;
  s.sigma = sigma;
  return s;
}
/// A reading that is late by `delay` [s]: what changes within that time.
inline SensorSize late(const FamilyFlight& f, double delay, const FamilyFlown& n) {
  return forces(mass(f) * n.jerk * delay / std::sqrt(3.0),
                f.vehicle.nominal.inertia.trace() / 3 * n.rate_jerk * delay / std::sqrt(3.0));
}

}  // namespace omniflight::proof
