// What a flight shall do: schema omniflight.mission/1.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_planning/payload.hpp"
#include "omniflight_planning/tether.hpp"
#include "omniflight_planning/timing.hpp"
#include "omniflight_planning/tube.hpp"
#include "omniflight_planning/zones.hpp"

namespace omniflight::planning {

struct Waypoint {
  std::string name;  ///< for messages; "waypoint 3" when the file gives none
  Pose pose;
  /// rad: the attitude is upright with this heading, whatever the vehicle, and pose.q_WB that of a vehicle
  /// whose thrust axis is z.
  std::optional<double> heading = {};
  double hold_s = 0.0;               ///< s at rest there; only for stops
  bool stop = true;                  ///< false: flown through
  std::optional<double> alpha = {};  ///< rad, tilt to move to on arrival, before holding; only for stops
  bool tilt_in_flight = false;       ///< the tilt moves on the way there, and not at rest on arrival
  std::string where;                 ///< file:line
};

/// What a plan prefers among the motions that keep every limit.
enum class Objective {
  time,       ///< the quickest ride of a short way
  energy,     ///< the ride that takes least from the rotors, of both timings at several speeds
  clearance,  ///< a way with as much room beyond the clearance as there is
};

struct Mission {
  std::string name;
  std::string vehicle;                ///< name or path, as load_vehicle takes it
  std::filesystem::path test_bed;     ///< the .bt, .ot or mesh file, resolved
  std::filesystem::path description;  ///< the test bed's YAML beside it, empty when there is none
  Zones zones = {};
  std::optional<double> alpha;  ///< rad, at the start; nothing = search
  std::optional<Tether> tether;
  std::optional<Payload> payload;
  std::vector<Waypoint> waypoints;  ///< the first one is the start
  MotionLimits limits;
  Objective objective = Objective::time;
  Timing timing = Timing::minimum_jerk;  ///< of vehicles that do not lean into their motion
  std::optional<double>
      tracking_position;  ///< m, position error that the flight may reach; nothing: see tube_of
  std::optional<double> tracking_attitude;  ///< rad, likewise
  bool tracking_in_margin = false;          ///< clearance is kept beyond these errors
  std::optional<Gust> gust;
  double clearance = 0.05;  ///< m that every point of the vehicle keeps from the map's voxels
  std::uint64_t seed = 1;
  double budget_s = 10.0;  ///< s for the whole plan, see plan()
  bool anytime = false;    ///< the whole budget is used to look for shorter paths
  std::string file;        ///< where it was read from
  std::string sha256;      ///< of that file
};

/// Reads a mission: a path, or a name under configs/missions. Errors name file, line, field and unit.
Result<Mission> load_mission(const std::string& spec);

}  // namespace omniflight::planning
