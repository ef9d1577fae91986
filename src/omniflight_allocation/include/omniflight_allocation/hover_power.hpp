// What hovering costs in every attitude at every tilt: power and loads of the rotors.
#pragma once

#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

/// Hovering in one attitude at one tilt with the least power.
struct HoverCost {
  bool possible = false;     ///< within the limits of the rotors, no torque about the centre of mass
  double power = 0;          ///< W mechanical, sum of drag torque times speed
  double largest_load = 0;   ///< of a rotor: thrust over its limit
  int working = 0;           ///< rotors that give at least a twentieth of the largest thrust there
  vehicle::RotorVector u{};  ///< N
};

/// The thrusts that carry the weight with `up_B` (unit, body axes) upward at tilt alpha [rad] and need least
/// sum drag_ratio |u|^1.5 / sqrt(thrust_coefficient): iteratively reweighted least squares, each an exact box
/// program. Rotors that need to turn (min_thrust of those that cannot reverse) do. Refuses an invalid vehicle
/// and a direction that is none.
Result<HoverCost> hover_cost(const vehicle::Vehicle& vehicle, double alpha, const Vec3& up_B);

/// All of them: a row a direction, a column a tilt.
struct HoverMap {
  std::vector<double> alpha;  ///< rad
  std::vector<double> lean;   ///< rad between body z and up, ascending
  /// Over `azimuths` directions of lean: the most expensive; not possible where any of them is not.
  std::vector<std::vector<HoverCost>> worst;  ///< [lean][alpha]
};
/// azimuths: 1 to 360, evenly about body z from x on.
Result<HoverMap> hover_map(const vehicle::Vehicle& vehicle, std::vector<double> alpha,
                           std::vector<double> lean, int azimuths);

}  // namespace omniflight::allocation
