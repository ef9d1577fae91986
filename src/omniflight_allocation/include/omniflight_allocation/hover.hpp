// Whether a vehicle can hold an attitude: for planners.
#pragma once

#include <optional>

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

/// Thrusts [N] that hold the vehicle at rest in attitude q_WB at tilt alpha [rad], or nothing when there are
/// none. headroom in [0, 1): share of every thrust range kept free, half of it at either end (0.2 of a
/// bidirectional rotor: |u| <= 0.8 max_thrust). Exact to 1e-6 of the weight: the thrusts balance the weight
/// to that, or a separating plane proves that none do; closer calls than that count as infeasible. Input that
/// is not finite: nothing.
std::optional<vehicle::RotorVector> hover_thrusts(const vehicle::Vehicle& vehicle, const Quat& q_WB,
                                                  double alpha, double headroom = 0);

inline bool hover_feasible(const vehicle::Vehicle& vehicle, const Quat& q_WB, double alpha,
                           double headroom = 0) {
  return hover_thrusts(vehicle, q_WB, alpha, headroom).has_value();
}

}  // namespace omniflight::allocation
