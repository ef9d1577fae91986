#include "omniflight_planning/plan.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "certify.hpp"
#include "knot_figures.hpp"
#include "octree_boxes.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/planner.hpp"
#include "pace.hpp"
#include "ride_leg.hpp"
#include "ride_tilting.hpp"
#include "stop_ride.hpp"
#include "text.hpp"
#include "upright.hpp"

namespace omniflight::planning {
namespace {

constexpr double kShareOfRestarts = 0.7;  // of the time that is left, once there is a path
constexpr double kShareOfSearch = 0.9;    // of the time that is left; the rest is for timing and certificate

Error to_error(const PathProblem& problem, const Waypoint& waypoint, const std::string& mission_file) {
  Error error;
  error.message = std::string(to_string(problem.failure)) + ": " + waypoint.name + ": " + problem.message;
  error.where = waypoint.where.empty() ? mission_file : waypoint.where;
  switch (problem.failure) {
    case PathFailure::no_path_in_time:
      error.code = ErrorCode::incomplete;
      error.next_step = "Give more budget_ms, less clearance_m or a via point";
      break;
    case PathFailure::gap_too_narrow:
      error.code = ErrorCode::incomplete;
      error.next_step =
          "Ask for less clearance_m, choose another alpha_deg or rotor_headroom, or open the gap";
      break;
    case PathFailure::proven_impossible:
      error.code = ErrorCode::impossible;
      error.next_step = "Move the waypoint or open the test bed";
      break;
    case PathFailure::tether_blocks_way:
      error.code = ErrorCode::incomplete;
      error.next_step = "Give a longer tether, another anchor or attachment, or a via point";
      break;
    case PathFailure::tether_too_short:
    case PathFailure::tether_blocked:
      error.code = ErrorCode::bad_input;
      error.next_step = "Give a longer tether or another anchor, or move the waypoint";
      break;
    case PathFailure::start_unhoverable:
    case PathFailure::goal_unhoverable:
      error.code = ErrorCode::bad_input;
      error.next_step = "Choose another alpha_deg (or search), another attitude or less rotor_headroom";
      break;
    default:
      error.code = ErrorCode::bad_input;
      error.next_step = "Move the waypoint or reduce clearance_m";
  }
  return error;
}

std::size_t knots_of(double seconds) { return static_cast<std::size_t>(std::lround(seconds / kKnotPeriod)); }

void hold(Knots& all, const Pose& pose, double alpha, double seconds) {
  TrajectoryKnot knot;
  knot.reference.p_WB = pose.p_WB;
  knot.reference.q_WB = pose.q_WB;
  knot.reference.alpha = alpha;
  const double t0 = all.empty() ? 0.0 : all.back().t;
  const std::size_t periods = knots_of(seconds);
  for (std::size_t i = all.empty() ? 0 : 1; i <= periods; ++i) {
    knot.t = t0 + static_cast<double>(i) * kKnotPeriod;
    all.push_back(knot);
  }
}

/// Knots of all holds and of some motion. A vector that grows copies itself, which for hours of holds takes
/// longer than a planning budget may be exceeded.
std::size_t expected_knots(const std::vector<Waypoint>& waypoints) {
  constexpr std::size_t kMotion = 10'000;
  std::size_t sum = kMotion;
  for (const Waypoint& w : waypoints) sum += knots_of(w.hold_s);
  return std::min(sum, kMaxKnots + kMotion);
}

/// A path that keeps more clearance than asked for where there is room: a curve needs some to round its
/// corners, and a vehicle that is blown aside likes it, too. Once there is one, shorter ones with the same
/// room are looked for in `shorter_s` [s].
PathResult<Path> find_roomy_path(const StateCheck& check, const Pose& start, const Pose& goal,
                                 const PathOptions& options, double shorter_s, Objective objective) {
  const auto search = [&](const StateCheck& roomy, const PathOptions& part) -> PathResult<Path> {
    auto path = find_path(roomy, start, goal, part);
    if (!path || shorter_s <= 0.0) return path;
    PathOptions more = part;
    more.budget_s = shorter_s;
    return find_shorter_path(roomy, std::move(*path), more);
  };
  std::vector<double> extras{0.10, 0.04};  // m
  if (objective == Objective::clearance) extras.insert(extras.begin(), {0.5, 0.35, 0.25, 0.16});
  for (const double extra : extras) {
    if (check.margin() + extra >= check.map().max_distance()) continue;  // farther than the field can tell
    const StateCheck roomy = check.with_margin(check.margin() + extra);
    if (!roomy.valid(start) || !roomy.valid(goal)) continue;
    PathOptions part = options;
    part.budget_s = 0.4 / static_cast<double>(extras.size()) * options.budget_s;
    part.brief = true;
    if (auto path = search(roomy, part)) return path;
  }
  PathOptions part = options;
  part.budget_s = 0.6 * options.budget_s;
  return search(check, part);
}

/// Of the rides by both timings, as fast as the limits allow and more slowly, the one that takes least
/// energy.
template <class Ride>
Result<Ridden> least_energy(const Ride& ride, const Mission& mission, Tilts& tilts,
                            const vehicle::Vehicle& vehicle, const Deadline& deadline) {
  auto best = ride(mission.limits, mission.timing);
  if (!best) return best;
  const auto first = energy_of(best->knots, tilts, vehicle, deadline);
  if (!first) return Failure(first.error());
  double least = first->value_or(0.0);
  for (const Timing timing : {Timing::shortest, Timing::minimum_jerk})
    for (const double pace : {1.0, 0.8, 0.6, 0.45, 0.3}) {
      if (deadline.passed() || !*first) return best;
      MotionLimits limits = mission.limits;
      limits.speed *= pace, limits.rate *= pace;
      limits.acceleration *= pace * pace, limits.angular_acceleration *= pace * pace;
      auto other = ride(limits, timing);
      if (!other) continue;
      const auto energy = energy_of(other->knots, tilts, vehicle, deadline);
      if (!energy) return Failure(energy.error());
      if (*energy && **energy < least) least = **energy, best = std::move(other);
    }
  return best;
}

/// Says of a search without a path whether the vehicle alone would have one.
PathProblem blame_tether(PathProblem problem, const StateCheck& check, const Pose& start, const Pose& goal,
                         PathOptions options) {
  options.budget_s = 0.5 * options.deadline.left();
  options.brief = true;
  if (find_path(check.with_tether({}), start, goal, options)) {
    problem.failure = PathFailure::tether_blocks_way;
    problem.message += "; the vehicle alone has a path, so the bottleneck is the tether";
  }
  return problem;
}

/// The stop that a plan begins with in flight; the mission goes on from where it ends.
Result<Knots> begin_in_flight(const FlightState& from, Mission& mission, const AtTilt& here,
                              const Deadline& deadline) {
  const Reference& r = from.reference;
  if (!is_finite({r.p_WB, r.q_WB}) || !r.v_WB_W.allFinite() || !r.a_WB_W.allFinite() ||
      !from.j_WB_W.allFinite() || !r.w_WB_B.allFinite() || !r.dw_WB_B.allFinite())
    return bad_input("the state in flight is not finite or its quaternion is not a unit one", "from");
  if (here.flat)
    return bad_input(
        "this vehicle leans into its motion, and plans from a state in flight are for vehicles that "
        "command their attitude",
        "from", "Let it come to rest, and plan from there");
  if (mission.tether && std::isfinite(mission.tether->twist))
    return bad_input("the tether has a limit of twist, and what has accumulated so far is not told", "from",
                     "Leave twist_deg out, or plan from the start");
  auto stop = come_to_rest(from, here, mission.limits, deadline);
  if (!stop) return stop;
  Waypoint& first = mission.waypoints.front();
  first.name = "the stop after the state in flight";
  first.pose = {stop->back().reference.p_WB, stop->back().reference.q_WB};
  first.heading.reset();
  first.hold_s = 0.0;
  return stop;
}

Result<Plan> plan_until(const Deadline& deadline, const Mission& asked, const vehicle::Vehicle& empty,
                        const DistanceMap& map, const PlanOptions& options) {
  const Pace pace;
  if (auto ok = check_planner(options.planner); !ok) return Failure(ok.error());
  if (auto ok = vehicle::validate(empty); !ok) return Failure(ok.error());
  const LoadedVehicle loaded = with_loads(asked, empty);
  const vehicle::Vehicle& vehicle = loaded.with_tether;
  auto resolved = with_headings(asked, vehicle);
  if (!resolved) return Failure(resolved.error());
  Mission& mission = *resolved;
  if (mission.waypoints.size() < 2) return bad_input("a mission needs a start and a waypoint", mission.file);
  Plan out;
  Certificate& c = out.certificate;
  const bool fixed = vehicle.tilt.kind == vehicle::TiltKind::none;
  if (options.from) mission.alpha = options.from->reference.alpha;
  c.alpha_searched = !fixed && !mission.alpha.has_value();
  const auto tube = tube_for(mission, vehicle, options.tube_file);
  if (!tube) return Failure(tube.error());
  if (const double margin = margin_of(*tube, cover_with_spheres(vehicle, vehicle.tilt.min), mission.tether);
      tube->in_margin && mission.clearance + margin >= kBoxHorizon)
    return bad_input(text("margin_too_large: clearance and tracking errors come to %.3f m together, and "
                          "plans are verified to %.1f m",
                          mission.clearance + margin, kBoxHorizon),
                     mission.file, "Track better, or ask for less clearance_m");
  Tilts tilts(mission, *tube, vehicle, map, deadline);
  if (fixed) {
    c.alpha = 0.0;
    if (mission.alpha.value_or(0.0) != 0.0)
      c.reason += text("alpha_deg does not apply: '%s' does not tilt its rotors; ", vehicle.name.c_str());
  } else if (mission.alpha) {
    c.alpha = *mission.alpha;
    if (auto ok = tilts.in_range(c.alpha, mission.file); !ok) return Failure(ok.error());
  } else {
    const auto found = search_alpha(mission, vehicle, deadline);
    if (!found) return Failure(found.error());
    c.alpha = *found;
  }
  Knots knots;
  if (options.from) {
    const auto here = tilts.at(c.alpha);
    if (!here) return Failure(here.error());
    auto stop = begin_in_flight(*options.from, mission, **here, deadline);
    if (!stop) return Failure(stop.error());
    knots = std::move(*stop);
    c.from = options.from;
  }
  PathOptions path_options;
  path_options.threads = options.threads;
  path_options.seed = options.seed.value_or(mission.seed);
  path_options.deadline = deadline;
  path_options.planner = options.planner;
  if (options.names)
    path_options.name_of = [bed = options.names](const Vec3& p) { return bed->nearest(p).name; };
  double alpha = c.alpha;
  for (std::size_t i = 0; i < mission.waypoints.size(); ++i) {
    const Waypoint& waypoint = mission.waypoints[i];
    if (deadline.passed()) return out_of_time(deadline, "checking the waypoints");
    if (waypoint.tilt_in_flight) alpha = waypoint.alpha.value_or(alpha);
    if (waypoint.alpha)
      if (auto ok = tilts.in_range(*waypoint.alpha, waypoint.where); !ok) return Failure(ok.error());
    const auto here = waypoint.stop ? tilts.at(alpha) : tilts.towards(i, alpha);
    if (!here) return Failure(here.error());
    if ((*here)->flat && mission.tether)
      return bad_input("tether: '" + vehicle.name +
                           "' leans into its motion, and plans with a tether are for "
                           "vehicles that command their attitude",
                       mission.file, "Leave the tether out");
    if ((*here)->flat)
      if (auto ok = check_upright(waypoint, *(*here)->flat, vehicle, i == 0, mission.file); !ok)
        return Failure(ok.error());
    if (auto ok = check_end((*here)->check, waypoint.pose, i == 0, path_options); !ok) {
      Error error = to_error(ok.error(), waypoint, mission.file);
      if (const double load = (*here)->rotors->load().hover_load(waypoint.pose.q_WB);
          load > 1.0 - mission.limits.rotor_headroom)
        error.message += text(": %s of %.4g kg needs %.0f %% of its rotors' range, %.0f %% are allowed",
                              files::shown(vehicle.name).c_str(), vehicle.mass, 100.0 * load,
                              100.0 * (1.0 - mission.limits.rotor_headroom));
      return Failure(error);
    }
    alpha = waypoint.alpha.value_or(alpha);
  }
  alpha = c.alpha;

  knots.reserve(knots.size() + expected_knots(mission.waypoints));
  hold(knots, mission.waypoints[0].pose, c.alpha, mission.waypoints[0].hold_s);
  std::vector<Path> leg;
  for (std::size_t i = 1; i < mission.waypoints.size(); ++i) {
    const Waypoint& goal = mission.waypoints[i];
    if (deadline.passed()) return out_of_time(deadline, "on the way to " + goal.name);
    path_options.budget_s = kShareOfSearch * deadline.left();
    const auto here = tilts.towards(i, alpha);
    if (!here) return Failure(here.error());
    // what is left is shared by the legs that are still to be planned
    const double shorter_s = mission.anytime ? kShareOfRestarts * deadline.left() /
                                                   static_cast<double>(mission.waypoints.size() - i)
                                             : 0.0;
    const auto part = find_roomy_path((*here)->check, mission.waypoints[i - 1].pose, goal.pose, path_options,
                                      shorter_s, mission.objective);
    if (!part) {
      PathProblem why = part.error();
      if (mission.tether)
        why = blame_tether(why, (*here)->check, mission.waypoints[i - 1].pose, goal.pose, path_options);
      return Failure(to_error(why, goal, mission.file));
    }
    if (path_length(*part) > 1e-6) leg.push_back(*part);
    if (!goal.stop) continue;
    if (!leg.empty()) {
      const bool tilts_on_the_way = goal.tilt_in_flight && *goal.alpha != alpha;
      const auto ride = [&](const MotionLimits& limits, Timing timing) {
        return tilts_on_the_way
                   ? ride_tilting(leg, alpha, *goal.alpha, vehicle, tilts, limits, timing, deadline)
                   : ride_leg(leg, **here, limits, timing, deadline);
      };
      auto ridden = mission.objective == Objective::energy
                        ? least_energy(ride, mission, tilts, vehicle, deadline)
                        : ride(mission.limits, mission.timing);
      if (!ridden) {
        Error error = ridden.error();
        error.message = goal.name + ": " + error.message;
        if (error.where.empty()) error.where = goal.where;
        return Failure(error);
      }
      if (ridden->stops_on_the_way) c.reason += "stops at every corner on the way to " + goal.name + "; ";
      append(knots, ridden->knots);
      if (tilts_on_the_way) alpha = *goal.alpha;
    }
    if (goal.alpha && *goal.alpha != alpha) {
      const auto move = tilts.move(alpha, goal);
      if (!move) return Failure(move.error());
      append(knots, *move);
      alpha = *goal.alpha;
    }
    hold(knots, goal.pose, alpha, goal.hold_s);
    if (knots.size() > kMaxKnots)
      return bad_input(text("the plan lasts longer than %.0f s", kMaxKnots * kKnotPeriod), goal.where,
                       "Hold for less (hold_s), or split the mission");
    leg.clear();
  }
  const auto axis = axis_of_motion(mission, c.alpha, tilts);
  if (!axis) return Failure(axis.error());
  c.leans = axis->has_value();
  if (c.leans && mission.timing == Timing::shortest)
    c.reason += "timing: shortest does not apply to vehicles that lean into their motion; ";
  c.thrust_axis_B = axis->value_or(Vec3::Zero());
  if (knots.size() < 2) return bad_input("the mission neither moves nor holds", mission.file);

  // interpolating cannot be interrupted: it is not begun when it would end too late at the pace so far
  constexpr double kPerKnot =
      4e-7;  // s, measured on one core of a server of 2020, with first use of the memory
  if (deadline.left() < pace.slowdown() * kPerKnot * static_cast<double>(knots.size()))
    return out_of_time(deadline, "interpolating the curve");
  auto trajectory = Trajectory::create(std::move(knots));
  if (!trajectory) return Failure(trajectory.error());
  c.mission = mission.name;
  c.mission_file = mission.file;
  c.mission_sha256 = mission.sha256;
  c.vehicle = vehicle.name;
  c.vehicle_file = options.vehicle.empty() ? mission.vehicle : options.vehicle;
  c.vehicle_set = options.set;
  c.vehicle_sha256 = vehicle.sha256;
  c.vehicle_mass = empty.mass;
  c.payload = mission.payload;
  c.map_file = options.map_file;
  c.map_sha256 = map.sha256();
  c.seed = path_options.seed;
  c.planner = options.planner;
  c.threads = options.threads;
  c.duration = trajectory->duration();
  c.tube = *tube;
  c.tube_margin = margin_of(*tube, cover_with_spheres(vehicle, c.alpha), mission.tether);
  c.clearance_asked = mission.clearance;
  c.clearance_horizon = map.max_distance();
  c.limits = mission.limits;
  if (auto ok = certify(*trajectory, vehicle, tilts, mission.limits.rotor_headroom, deadline, c); !ok)
    return Failure(ok.error());
  if (mission.tether)
    if (auto ok = certify_tether(mission, loaded.without_tether, trajectory->knots(), c); !ok)
      return Failure(ok.error());
  if (options.figures) {
    auto figures = figures_of(trajectory->knots(), tilts, deadline);
    if (!figures) return Failure(figures.error());
    out.figures = std::move(*figures);
    const auto energy = energy_of(trajectory->knots(), tilts, vehicle, deadline);
    if (!energy) return Failure(energy.error());
    c.energy = *energy;
  }
  out.trajectory = std::move(*trajectory);
  return out;
}

Deadline deadline_of(const Mission& mission, const PlanOptions& options) {
  return Deadline(options.budget_s.value_or(mission.budget_s), options.stop);
}

}  // namespace

Result<Plan> plan(const Mission& mission, const vehicle::Vehicle& vehicle, const DistanceMap& map,
                  const PlanOptions& options) {
  return plan_until(deadline_of(mission, options), mission, vehicle, map, options);
}

Result<Plan> plan_mission(const Mission& mission, const PlanOptions& options) {
  const Deadline deadline = deadline_of(mission, options);
  const auto vehicle =
      vehicle::load_vehicle(options.vehicle.empty() ? mission.vehicle : options.vehicle, options.set);
  if (!vehicle) return Failure(vehicle.error());
  auto map = DistanceMap::load(
      mission.test_bed,
      {.unknown = mission.zones.unknown, .deadline = deadline, .cache = field_cache_folder()});
  if (!map) return Failure(map.error());
  if (auto ok = map->close(mission.zones, deadline); !ok) return Failure(ok.error());
  PlanOptions with_names = options;
  with_names.map_file = mission.test_bed.string();
  Result<TestBed> bed = TestBed{};
  if (!mission.description.empty() && !options.names) {
    bed = load_test_bed(mission.description);
    if (!bed) return Failure(bed.error());
    bed->primitives.insert(bed->primitives.end(), mission.zones.keep_out.begin(),
                           mission.zones.keep_out.end());
    with_names.names = &*bed;
  }
  auto made = plan_until(deadline, mission, *vehicle, *map, with_names);
  if (made && !map->cache_remark().empty()) made->certificate.reason += map->cache_remark() + "; ";
  return made;
}

}  // namespace omniflight::planning
