// Where a descent of the failsafe ends: on what the mission's map has below the vehicle, else at the ground
// of the test bed.
#pragma once

#include <optional>
#include <string>

#include "omniflight_bus/parameters.hpp"
#include "omniflight_planning/surface_below.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::components {

struct LandingConfig {
  double ground_z = 0.0;   ///< m, world; the reference of a descent ends there where nothing is above it
  double touchdown = 0.1;  ///< m of the body origin above it that count as landed
  double contact = 0.05;   ///< m above the first contact with the map that count as landed: a voxel of it
};

/// What the map is and what comes down on it.
struct MapBelow {
  planning::SurfaceBelow surface;
  vehicle::Vehicle vehicle;
};

/// `map` (a .bt, .ot or mesh file; empty: nothing), `vehicle` and `vehicle_set` (overrides separated by ';').
Result<std::optional<MapBelow>> read_map_below(bus::Parameters& parameters);

class LandingPlace {
 public:
  explicit LandingPlace(const LandingConfig& config, std::optional<MapBelow> below = {})
      : config_(config), below_(std::move(below)) {}

  /// Once, where the descent begins, with the rotors at tilt alpha [rad]. Allocates.
  void begin(const RigidState& estimate, double alpha);
  /// Every control period of the descent: the vehicle may drift.
  void look(const RigidState& estimate);

  bool landed(const Vec3& p_WB) const;
  /// m, world: how far down the reference goes.
  double lowest() const;
  /// "ends on what the map has at 0.60 m, the body origin at 0.80 m", or at the ground; heights of the world.
  std::string words() const;

 private:
  /// Whether contact with the map comes before the ground.
  bool on_map() const {
    return contact_ && contact_->p_z + config_.contact > config_.ground_z + config_.touchdown;
  }

  LandingConfig config_;
  std::optional<MapBelow> below_;
  planning::VehicleSpheres spheres_;
  std::optional<planning::Landing> contact_;
};

}  // namespace omniflight::components
