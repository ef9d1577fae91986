// What a plan checks states with, at each tilt of the rotors that it uses.
#pragma once

#include <map>

#include "omniflight_planning/flatness.hpp"
#include "omniflight_planning/mission.hpp"
#include "omniflight_planning/state_check.hpp"
#include "tilt_way.hpp"

namespace omniflight::planning {

/// What a state is checked with while the rotors stand at one tilt.
struct AtTilt {
  std::shared_ptr<const Rotors> rotors;
  StateCheck check;
  std::optional<FlatVehicle> flat;  ///< set where the attitude follows from the acceleration
};

/// A vehicle with what a mission puts on it: its payload, and the whole mass of its tether or none of it.
struct LoadedVehicle {
  vehicle::Vehicle without_tether, with_tether;
};
LoadedVehicle with_loads(const Mission& mission, const vehicle::Vehicle& vehicle);

/// Way [m] that no point of the vehicle, its tether's attachment included, is off its reference.
double margin_of(const Tube& tube, const VehicleSpheres& spheres, const std::optional<Tether>& tether);

class Tilts {
 public:
  Tilts(const Mission& mission, const Tube& tube, const vehicle::Vehicle& vehicle, const DistanceMap& map,
        const Deadline& deadline)
      : mission_(mission), tube_(tube), vehicle_(vehicle), map_(map), deadline_(deadline) {}

  /// Made when first asked for.
  Result<const AtTilt*> at(double alpha);

  /// While the tilt moves from one to another: free at all of them, and held at one of them. Refused where
  /// the vehicle leans into its motion at one.
  Result<const AtTilt*> between(double from, double to, const std::string& where);
  /// What the way to waypoint i is checked with that begins at a tilt: at this one, or between it and that of
  /// the next stop where it moves there in flight.
  Result<const AtTilt*> towards(std::size_t i, double from);
  Result<TiltRange> range(double from, double to);

  /// Refuses a tilt [rad] outside the vehicle's range.
  Status in_range(double alpha, const std::string& where) const;

  /// The move to the tilt of a waypoint, the vehicle resting there: free and hoverable every degree, with
  /// room for what the rims travel in between.
  Result<std::vector<TrajectoryKnot>> move(double from, const Waypoint& to);

 private:
  const Mission& mission_;
  const Tube& tube_;
  const vehicle::Vehicle& vehicle_;
  const DistanceMap& map_;
  Deadline deadline_;
  std::map<double, AtTilt> known_;
  std::map<std::pair<double, double>, AtTilt> known_between_;
};

}  // namespace omniflight::planning
