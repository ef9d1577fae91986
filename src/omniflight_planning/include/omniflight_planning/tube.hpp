// How far a flight may be off its reference, and the margin that pays for it.
#pragma once

#include <filesystem>
#include <string>

#include "omniflight_core/result.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

struct Mission;

struct Tube {
  double position = 0.0;    ///< m, of the body origin, the gust's part included
  double attitude = 0.0;    ///< rad
  bool in_margin = false;   ///< the clearance is kept beyond it; otherwise clearance must pay for it
  std::string file = {};    ///< the flight.json or compare.json where it was measured; may be empty
  std::string sha256 = {};  ///< of that file

  /// Way [m] that no vehicle point within `reach` [m] of the body origin exceeds; 0 unless in_margin.
  double margin(double reach) const { return in_margin ? position + attitude * reach : 0.0; }
};

/// A gust that holds as long as it likes: the controller gives way by force times compliance.
struct Gust {
  double force = 0.0;       ///< N
  double compliance = 0.0;  ///< m/N, position error of the controlled vehicle for a force held
  double way() const { return force * compliance; }  ///< m
};

/// The mission's tracking bounds. Where it gives none: the position error that uses up the clearance, and the
/// turn that moves the vehicle's outermost point by as much; clearances below 2 cm count as 2 cm.
Tube tube_of(const Mission& mission, const vehicle::Vehicle& vehicle);

/// The largest errors of flights, as `fly` (flight.json) and `compare` (compare.json, of the recorded
/// flight) write them. Refused: flights that ended early, and errors beyond 5 m or 90 degrees.
Result<Tube> read_tube(const std::filesystem::path& file);

/// What a plan must keep: measured in `file` where one is given, else the mission's, and the gust's way.
/// In the margin where it was measured, the mission says so (tracking.in_margin) or names a gust.
Result<Tube> tube_for(const Mission& mission, const vehicle::Vehicle& vehicle,
                      const std::filesystem::path& file);

}  // namespace omniflight::planning
