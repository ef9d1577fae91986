// The tilt over time that a motion known in advance costs least with: what a search from one period to the
// next cannot see is that a tilt must have begun to move before it is needed.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "omniflight_allocation/config.hpp"
#include "omniflight_core/trajectory.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

struct LookAheadConfig {
  AllocatorConfig weights = AllocatorConfig::case_b();  ///< W1 and W2 of the costs; W3 does not count
  double rate = 0;                ///< rad/s that the tilt moves at most; 0: the vehicle's
  double grid = to_radians(0.5);  ///< rad between tilts
  double period = 0.05;           ///< s between decisions, about
  double reserve = 0.1;           ///< share of every rotor's thrust that is kept where it can be, [0, 0.9]
  std::optional<double> initial = {};  ///< rad at the start; nothing: any
  /// Share of the believed thrust that rotors give at a tilt [rad], in (0, 10]; nothing: all of it.
  std::function<double(double alpha)> thrust_share = {};
};

struct TiltSchedule {
  double period = 0;          ///< s
  std::vector<double> alpha;  ///< rad, at multiples of the period from the start of the motion
  double missing = 0;         ///< m/s^2 or rad/s^2, largest acceleration that is not achieved on the way
  double at(double t) const;  ///< rad, linear between; held before the start and after the end
};

/// Dynamic programming over a grid of tilts (Bellman): of all sequences within the tilt limits and the rate,
/// the one with the least sum over the motion of the least value of equation 4.3 at each tilt. Of equals the
/// one that moves less. duration [s] up to 3600. Refuses invalid configs and vehicles, motions that are not
/// finite, and vehicles that do not tilt.
Result<TiltSchedule> look_ahead(const vehicle::Vehicle& vehicle,
                                const std::function<Reference(double t)>& motion, double duration,
                                const LookAheadConfig& config = {});

}  // namespace omniflight::allocation
