// A mission made into a timed 6D trajectory with a certificate of what was checked.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/trajectory.hpp"
#include "omniflight_planning/join.hpp"
#include "omniflight_planning/map.hpp"
#include "omniflight_planning/mission.hpp"
#include "omniflight_planning/test_bed.hpp"
#include "omniflight_planning/tube.hpp"

namespace omniflight::planning {

/// What was checked, with which inputs, and the worst values found. Stored as certificate.json.
struct Certificate {
  std::string verdict = "certified";  ///< certified | rejected
  std::string reason;                 ///< why it was rejected, or what the plan had to give up
  std::string mission, vehicle;       ///< names
  std::string mission_file, vehicle_file, map_file;
  std::string mission_sha256, vehicle_sha256, map_sha256;
  std::vector<std::string> vehicle_set;  ///< overrides of its fields, "mass=1.4" (kg)
  double vehicle_mass = 0.0;             ///< kg
  std::uint64_t seed = 0;
  std::string planner;  ///< that alone looked for paths; empty: see find_path()
  int threads = 1;      ///< that looked for paths
  /// The state in flight that the trajectory begins with, instead of the mission's start at rest.
  std::optional<FlightState> from = {};
  double alpha = 0.0;                          ///< rad, at the start
  double alpha_lowest = 0, alpha_highest = 0;  ///< rad, on the way
  bool alpha_searched = false;
  bool tilts_in_flight = false;       ///< the tilt moves while the vehicle does
  double peak_tilt_rate = 0.0;        ///< rad/s
  bool leans = false;                 ///< the attitude follows from the acceleration (flatness.hpp)
  Vec3 thrust_axis_B = Vec3::Zero();  ///< unit, where it leans
  double duration = 0.0;              ///< s
  /// J that the drag of the rotors takes, holds included; where figures were asked for, and there was time.
  std::optional<double> energy = {};
  Tube tube;                       ///< that the flight must keep within
  double tube_margin = 0.0;        ///< m, kept beyond clearance_asked
  double clearance_asked = 0.0;    ///< m; no point of the curve is nearer to an occupied voxel
  double min_clearance = 0.0;      ///< m, least on the knots (lower bound; cut off at clearance_horizon)
  double min_clearance_at = 0.0;   ///< s
  double clearance_horizon = 0.0;  ///< m
  std::size_t witnesses = 0;       ///< poses looked at along the curve
  std::optional<TetherUse> tether;
  std::optional<Payload> payload;  ///< that the rotors carry beside the vehicle
  MotionLimits limits;
  MotionPeaks peak;  ///< on the knots
};

/// What a knot asks of the rotors, and how near it is to the map.
struct KnotFigures {
  double clearance = 0.0;   ///< m, lower bound, cut off at the certificate's clearance_horizon
  double headroom = 0.0;    ///< share of the rotors' range that is left
  Eigen::VectorXd thrusts;  ///< N, of the rotors
};

struct Plan {
  Trajectory trajectory;  ///< knots every 10 ms
  Certificate certificate;
  std::vector<KnotFigures>
      figures;  ///< of the first knots or of all, where PlanOptions::figures asked for them
};

struct PlanOptions {
  std::optional<std::uint64_t> seed;  ///< instead of the mission's
  std::optional<double> budget_s;     ///< s for the whole plan, instead of the mission's
  bool (*stop)() = nullptr;           ///< ends planning once it is true; may be absent
  const TestBed* names = nullptr;     ///< to name what is hit in messages; may be absent
  std::string map_file;               ///< recorded in the certificate
  std::string planner;                ///< one of planner_names(); empty: find_path() tries several
  std::filesystem::path tube_file;    ///< measured errors as margin, see tube_for(); may be empty
  std::string vehicle;                ///< instead of the mission's; as load_vehicle takes it
  std::vector<std::string> set;       ///< overrides of the vehicle's fields, as load_vehicle takes them
  int threads = 1;                    ///< that look for paths side by side, see PathOptions::threads
  /// Plans from this state in flight, instead of the mission's start (replanning): the trajectory has its
  /// position to the third derivative and its attitude to the second, comes to rest as soon as limits and map
  /// allow, and goes on to the mission's waypoints from there. For vehicles that command their attitude,
  /// without a limit of twist. Where there is no such plan, the error says why; nothing else changes.
  std::optional<FlightState> from = {};
  bool figures = false;  ///< fills Plan::figures, in what is left of the budget
};

/// Plans every leg, rounds it, times it and checks the curve itself. All of that ends within the budget and
/// 100 ms, with a plan or with why there is none. Deterministic for a seed as long as the budget suffices.
/// The map has the zones of the mission closed. Errors begin with the kind of failure (PathFailure or
/// alpha_out_of_range, curve_blocked,
/// ...), name the waypoint, and carry code bad_input, incomplete (no path in time) or impossible (proven).
Result<Plan> plan(const Mission& mission, const vehicle::Vehicle& vehicle, const DistanceMap& map,
                  const PlanOptions& options = {});

/// Loads vehicle, map and names of the mission and plans; the budget begins with loading.
Result<Plan> plan_mission(const Mission& mission, const PlanOptions& options = {});

/// The tilt [rad] within the vehicle's range, in steps of 1 degree, at which hovering every waypoint with the
/// mission's acceleration in any world axis needs the smallest share of the rotors' range.
Result<double> search_alpha(const Mission& mission, const vehicle::Vehicle& vehicle,
                            const Deadline& deadline = {});

/// A few sentences for people: what was planned and how near the limits it comes, or why there is no plan.
std::string explain(const Result<Plan>& plan);

/// trajectory.json (schema omniflight.trajectory/1), trajectory.csv (canonical ref_* columns, jerk, and where
/// the plan has figures u1_N ..., clearance_m and headroom), certificate.json.
Status write_plan(const Plan& plan, const std::filesystem::path& dir);

/// Reads trajectory.json and certificate.json; every number is checked to be finite and within wide bounds,
/// and the trajectory's hash must be the one in the certificate.
Result<Plan> read_plan(const std::filesystem::path& dir);

/// That a plan was made for this mission, vehicle and map: their hashes and the mass are the certificate's.
/// The error tells every difference. `vehicle` is the one that shall fly, overrides included.
Status check_match(const Certificate& certificate, const Mission& mission, const vehicle::Vehicle& vehicle);

struct VerifyReport {
  double min_clearance = 0.0;     ///< m, exact distance of the vehicle's parts to the octree's occupied boxes
  double min_clearance_at = 0.0;  ///< s
  std::size_t poses = 0;          ///< looked at
  MotionPeaks peak;
  double duration = 0.0;  ///< s
};

/// Checks a stored plan again without the distance field: hashes of map, vehicle and mission, limits, rotor
/// loads, waypoints, and clearance along the curve by exact distances to the boxes of the octree.
Result<VerifyReport> verify(const std::filesystem::path& dir);

}  // namespace omniflight::planning
