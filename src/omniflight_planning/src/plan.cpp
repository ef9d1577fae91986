#include "omniflight_planning/plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/planner.hpp"
#include "tilt.hpp"

namespace omniflight::planning {
namespace {

using Knots = std::vector<TrajectoryKnot>;

constexpr double kShareOfSearch = 0.9;  // of the time that is left; the rest is for timing and certificate
constexpr std::size_t kMaxKnots = 1'000'000;  // as many as a plan file may hold: 2 h 46 min

std::string text(const char* format, auto... values) {
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

Error to_error(const PathProblem& problem, const Waypoint& waypoint, const std::string& mission_file) {
  Error error;
  error.message = std::string(to_string(problem.failure)) + ": " + waypoint.name + ": " + problem.message;
  error.where = waypoint.where.empty() ? mission_file : waypoint.where;
  switch (problem.failure) {
    case PathFailure::no_path_in_time:
      error.code = ErrorCode::incomplete;
      error.next_step = "Give more budget_ms, less clearance_m or a via point";
      break;
    case PathFailure::proven_impossible:
      error.code = ErrorCode::impossible;
      error.next_step = "Move the waypoint or open the test bed";
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

using Path = std::vector<Pose>;

/// Each motion of a path cut into `parts`, so that a spline through it hugs the path more closely.
Path subdivided(const Path& path, int parts) {
  Path out{path.front()};
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    for (int k = 1; k <= parts; ++k)
      out.push_back(interpolate(path[i], path[i + 1], static_cast<double>(k) / parts));
  return out;
}

/// Corners cut (Chaikin): a quarter of each motion before and after an inner corner replaces it.
Path cut_corners(const Path& path, int times) {
  Path out = path;
  for (int i = 0; i < times && out.size() > 2; ++i) {
    Path next{out.front()};
    for (std::size_t k = 0; k + 1 < out.size(); ++k) {
      if (k > 0) next.push_back(interpolate(out[k], out[k + 1], 0.25));
      if (k + 2 < out.size()) next.push_back(interpolate(out[k], out[k + 1], 0.75));
    }
    next.push_back(out.back());
    out = std::move(next);
  }
  return out;
}

void append(Knots& all, const Knots& more) {
  const double t0 = all.empty() ? 0.0 : all.back().t;
  for (std::size_t i = all.empty() ? 0 : 1; i < more.size(); ++i) {
    all.push_back(more[i]);
    all.back().t += t0;
  }
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

struct Ridden {
  Knots knots;
  bool stops_on_the_way = false;
};

/// The fastest ride of a leg (one path between each two of its waypoints) that the map and the rotors allow:
/// on one curve through the waypoints, rounder or closer to the path, or with a stop at every corner, where
/// the curve is the path.
Result<Ridden> ride_leg(const std::vector<Path>& paths, const StateCheck& check,
                        const allocation::RotorLoad& rotors, const MotionLimits& limits,
                        const Deadline& deadline) {
  const auto joined = [&](auto shape) {
    Path all{paths.front().front()};
    for (const Path& path : paths) {
      const Path shaped = shape(path);
      all.insert(all.end(), shaped.begin() + 1, shaped.end());
    }
    return all;
  };
  const Path corners = joined([](const Path& p) { return p; });
  std::vector<Path> shapes{corners};
  if (corners.size() > 2) {
    for (const int times : {1, 2})
      shapes.push_back(joined([&](const Path& p) { return cut_corners(p, times); }));
    for (const int parts : {3, 6})
      shapes.push_back(joined([&](const Path& p) { return subdivided(p, parts); }));
  }
  Ridden best;
  std::optional<Error> problem;
  const auto offer = [&](Knots knots, bool stops) {
    if (!best.knots.empty() && knots.back().t >= best.knots.back().t) return;
    const auto trajectory = Trajectory::create(knots);
    if (trajectory && check.curve(*trajectory, deadline).free) best = {std::move(knots), stops};
  };
  for (const Path& shape : shapes) {
    if (deadline.passed()) return out_of_time(deadline, "timing a ride");
    auto knots = ride(PoseCurve(shape), rotors, limits, deadline);
    if (knots)
      offer(std::move(*knots), false);
    else
      problem = knots.error();
  }
  if (corners.size() > 2) {
    Knots knots;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      auto part = ride(PoseCurve({corners[i], corners[i + 1]}), rotors, limits, deadline);
      if (!part) return Failure(part.error());
      append(knots, *part);
    }
    offer(std::move(knots), true);
  }
  if (deadline.passed()) return out_of_time(deadline, "timing a ride");
  if (!best.knots.empty()) return best;
  if (problem) return Failure(*problem);
  return fail(ErrorCode::incomplete,
              "curve_blocked: the timed curve does not keep the clearance of the path");
}

/// A path that keeps more clearance than asked for where there is room: a curve needs some to round its
/// corners, and a vehicle that is blown aside likes it, too.
PathResult<Path> find_roomy_path(const StateCheck& check, const Pose& start, const Pose& goal,
                                 const PathOptions& options) {
  for (const double extra : {0.10, 0.04}) {
    const StateCheck roomy = check.with_margin(check.margin() + extra);
    if (!roomy.valid(start) || !roomy.valid(goal)) continue;
    PathOptions part = options;
    part.budget_s = 0.2 * options.budget_s;
    if (auto path = find_path(roomy, start, goal, part)) return path;
  }
  PathOptions part = options;
  part.budget_s = 0.6 * options.budget_s;
  return find_path(check, start, goal, part);
}

/// What a state is checked with while the rotors stand at one tilt.
struct AtTilt {
  std::shared_ptr<const allocation::RotorLoad> rotors;
  StateCheck check;
};

class Tilts {
 public:
  Tilts(const Mission& mission, const vehicle::Vehicle& vehicle, const DistanceMap& map,
        const Deadline& deadline)
      : mission_(mission), vehicle_(vehicle), map_(map), deadline_(deadline) {}

  /// Made when first asked for.
  Result<const AtTilt*> at(double alpha) {
    if (const auto known = known_.find(alpha); known != known_.end()) return &known->second;
    auto load = allocation::RotorLoad::create(vehicle_, alpha);
    if (!load) return Failure(load.error());
    auto rotors = std::make_shared<const allocation::RotorLoad>(std::move(*load));
    StateCheck check(map_, cover_with_spheres(vehicle_, alpha), rotors, mission_.limits.rotor_headroom,
                     mission_.clearance);
    return &known_.emplace(alpha, AtTilt{std::move(rotors), std::move(check)}).first->second;
  }

  Status in_range(double alpha, const std::string& where) const {
    if (alpha >= vehicle_.tilt.min - 1e-9 && alpha <= vehicle_.tilt.max + 1e-9) return {};
    return bad_input(
        text("alpha_out_of_range: %.2f deg is outside the range of '%s', [%.1f, %.1f] deg", to_degrees(alpha),
             vehicle_.name.c_str(), to_degrees(vehicle_.tilt.min), to_degrees(vehicle_.tilt.max)),
        where + ": alpha_deg", "Choose an angle within the range");
  }

  /// The move to the tilt of a waypoint, the vehicle resting there: free and hoverable every degree, with
  /// room for what the rims travel in between.
  Result<Knots> move(double from, const Waypoint& to) {
    const double change = *to.alpha - from;
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to_degrees(change)))));
    for (int k = 0; k <= steps; ++k) {
      if (deadline_.passed()) return out_of_time(deadline_, "checking a move of the tilt");
      const double alpha = from + change * k / steps;
      const auto here = at(alpha);
      if (!here) return Failure(here.error());
      const StateCheck& check = (*here)->check;
      if (check.with_margin(check.margin() + rim_travel(vehicle_, change / steps)).valid(to.pose)) continue;
      const bool hovers = check.hoverable(to.pose.q_WB);
      return fail(ErrorCode::bad_input,
                  text("tilt_blocked: %s: at alpha %.1f deg, on the way from %.1f to %.1f deg, %s",
                       to.name.c_str(), to_degrees(alpha), to_degrees(from), to_degrees(*to.alpha),
                       hovers ? "the vehicle does not keep its clearance"
                              : "the rotors cannot hold the attitude with the headroom asked for"),
                  to.where, "Move the tilt at another waypoint, or less");
    }
    return move_tilt(to.pose, from, *to.alpha, vehicle_.tilt.rate);
  }

 private:
  const Mission& mission_;
  const vehicle::Vehicle& vehicle_;
  const DistanceMap& map_;
  Deadline deadline_;
  std::map<double, AtTilt> known_;
};

/// Checks the finished curve, every piece at its own tilt, and fills in what the certificate says of it.
Status certify(const Trajectory& trajectory, const vehicle::Vehicle& vehicle, Tilts& tilts, double headroom,
               const Deadline& deadline, Certificate& c) {
  c.min_clearance = c.clearance_horizon;
  c.alpha_lowest = c.alpha_highest = c.alpha;
  const Knots& all = trajectory.knots();
  const auto late = [&] { return out_of_time(deadline, "checking the finished curve"); };
  for (const TiltPiece& piece : tilt_pieces(all)) {
    if (deadline.passed()) return late();
    const double tilt = all[piece.first].reference.alpha, start = all[piece.first].t;
    c.alpha_lowest = std::min(c.alpha_lowest, tilt), c.alpha_highest = std::max(c.alpha_highest, tilt);
    if (piece.moves) {  // its room was checked when it was made
      const auto most = peaks_while_tilting(vehicle, all, piece);
      if (!most) return Failure(most.error());
      if (most->rotor_load > 1.0 - headroom)
        return fail(ErrorCode::incomplete,
                    text("tilt_blocked: moving the tilt needs %.0f %% of the rotors' range at %.2f s",
                         100.0 * most->rotor_load, most->rotor_load_at),
                    c.mission_file, "Move the tilt less, or at another attitude");
      c.peak = larger(c.peak, *most, 0.0);
      continue;
    }
    // hours of holds have millions of knots, which are copied only where the tilt cuts the curve into pieces
    std::optional<Trajectory> cut;
    if (piece.first > 0 || piece.last + 1 < all.size() || start != 0.0) {
      Knots knots(all.begin() + static_cast<std::ptrdiff_t>(piece.first),
                  all.begin() + static_cast<std::ptrdiff_t>(piece.last) + 1);
      for (TrajectoryKnot& knot : knots) knot.t -= start;
      auto made = Trajectory::create(std::move(knots));
      if (!made) return Failure(made.error());
      cut.emplace(std::move(*made));
    }
    const Trajectory& part = cut ? *cut : trajectory;
    if (deadline.passed()) return late();
    const auto here = tilts.at(tilt);
    if (!here) return Failure(here.error());
    const CurveCheck curve = (*here)->check.curve(part, deadline);
    if (curve.out_of_time) return late();
    if (!curve.free)
      return fail(ErrorCode::incomplete,
                  text("curve_blocked: the curve comes within %.3f m at %.2f s", curve.min_clearance,
                       start + curve.at),
                  c.mission_file, "Reduce clearance_m or add waypoints");
    c.witnesses += curve.witnesses;
    if (curve.min_clearance < c.min_clearance)
      c.min_clearance = curve.min_clearance, c.min_clearance_at = start + curve.at;
    if (deadline.passed()) return late();
    c.peak = larger(c.peak, peaks(part.knots(), *(*here)->rotors), start);
  }
  return {};
}

}  // namespace

Result<double> search_alpha(const Mission& mission, const vehicle::Vehicle& vehicle,
                            const Deadline& deadline) {
  double best = vehicle.tilt.min, least = std::numeric_limits<double>::infinity();
  const int steps = static_cast<int>(std::floor(to_degrees(vehicle.tilt.max - vehicle.tilt.min) + 1e-9));
  for (int i = 0; i <= steps; ++i) {
    if (deadline.passed()) return out_of_time(deadline, "searching alpha");
    const double alpha = vehicle.tilt.min + to_radians(i);
    const auto rotors = allocation::RotorLoad::create(vehicle, alpha);
    if (!rotors) return Failure(rotors.error());
    double worst = 0.0;
    for (std::size_t k = 0; k < mission.waypoints.size(); ++k) {
      const Quat& q0 = mission.waypoints[k == 0 ? 0 : k - 1].pose.q_WB;
      for (int part = 0; part <= 4; ++part) {
        Reference r;
        r.q_WB = q0.slerp(0.25 * part, mission.waypoints[k].pose.q_WB);
        for (int axis = 0; axis < 6; ++axis) {
          r.a_WB_W.setZero();
          r.a_WB_W[axis % 3] = (axis < 3 ? 1.0 : -1.0) * mission.limits.acceleration;
          worst = std::max(worst, rotors->motion_load(r));
        }
      }
    }
    if (worst < least - 1e-9) {
      least = worst;
      best = alpha;
    }
  }
  if (!(least <= 1.0 - mission.limits.rotor_headroom))
    return bad_input(
        text("goal_unhoverable: no alpha between %.0f and %.0f deg lets '%s' hold the mission's attitudes; "
             "the best, %.0f deg, needs %.0f %% of the rotors' range and %.0f %% are allowed",
             to_degrees(vehicle.tilt.min), to_degrees(vehicle.tilt.max), vehicle.name.c_str(),
             to_degrees(best), 100.0 * least, 100.0 * (1.0 - mission.limits.rotor_headroom)),
        mission.file + ": waypoints", "Tilt less, lower limits.acceleration_mps2 or rotor_headroom");
  return best;
}

namespace {

Result<Plan> plan_until(const Deadline& deadline, const Mission& mission, const vehicle::Vehicle& vehicle,
                        const DistanceMap& map, const PlanOptions& options) {
  if (auto ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (mission.waypoints.size() < 2) return bad_input("a mission needs a start and a waypoint", mission.file);
  Plan out;
  Certificate& c = out.certificate;
  c.alpha_searched = !mission.alpha.has_value();
  Tilts tilts(mission, vehicle, map, deadline);
  if (mission.alpha) {
    c.alpha = *mission.alpha;
    if (auto ok = tilts.in_range(c.alpha, mission.file); !ok) return Failure(ok.error());
  } else {
    const auto found = search_alpha(mission, vehicle, deadline);
    if (!found) return Failure(found.error());
    c.alpha = *found;
  }
  PathOptions path_options;
  path_options.seed = options.seed.value_or(mission.seed);
  path_options.deadline = deadline;
  if (options.names)
    path_options.name_of = [bed = options.names](const Vec3& p) { return bed->nearest(p).name; };
  double alpha = c.alpha;
  for (std::size_t i = 0; i < mission.waypoints.size(); ++i) {
    const Waypoint& waypoint = mission.waypoints[i];
    if (deadline.passed()) return out_of_time(deadline, "checking the waypoints");
    const auto here = tilts.at(alpha);
    if (!here) return Failure(here.error());
    if (auto ok = check_end((*here)->check, waypoint.pose, i == 0, path_options); !ok) {
      Error error = to_error(ok.error(), waypoint, mission.file);
      if (const double load = (*here)->rotors->hover_load(waypoint.pose.q_WB);
          load > 1.0 - mission.limits.rotor_headroom)
        error.message += text(": %s of %.4g kg needs %.0f %% of its rotors' range, %.0f %% are allowed",
                              files::shown(vehicle.name).c_str(), vehicle.mass, 100.0 * load,
                              100.0 * (1.0 - mission.limits.rotor_headroom));
      return Failure(error);
    }
    if (waypoint.alpha)
      if (auto ok = tilts.in_range(*waypoint.alpha, waypoint.where); !ok) return Failure(ok.error());
    alpha = waypoint.alpha.value_or(alpha);
  }
  alpha = c.alpha;

  Knots knots;
  knots.reserve(expected_knots(mission.waypoints));
  hold(knots, mission.waypoints[0].pose, c.alpha, mission.waypoints[0].hold_s);
  std::vector<Path> leg;
  for (std::size_t i = 1; i < mission.waypoints.size(); ++i) {
    const Waypoint& goal = mission.waypoints[i];
    if (deadline.passed()) return out_of_time(deadline, "on the way to " + goal.name);
    path_options.budget_s = kShareOfSearch * deadline.left();
    const auto here = tilts.at(alpha);
    if (!here) return Failure(here.error());
    const auto part = find_roomy_path((*here)->check, mission.waypoints[i - 1].pose, goal.pose, path_options);
    if (!part) return Failure(to_error(part.error(), goal, mission.file));
    if (path_length(*part) > 1e-6) leg.push_back(*part);
    if (!goal.stop) continue;
    if (!leg.empty()) {
      auto ridden = ride_leg(leg, (*here)->check, *(*here)->rotors, mission.limits, deadline);
      if (!ridden) {
        Error error = ridden.error();
        error.message = goal.name + ": " + error.message;
        if (error.where.empty()) error.where = goal.where;
        return Failure(error);
      }
      if (ridden->stops_on_the_way) c.reason += "stops at every corner on the way to " + goal.name + "; ";
      append(knots, ridden->knots);
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
  if (knots.size() < 2) return bad_input("the mission neither moves nor holds", mission.file);

  // interpolating cannot be interrupted: it is not begun when it would end too late
  constexpr double kPerKnot =
      4e-7;  // s, measured on one core of a server of 2020, with first use of the memory
  if (deadline.left() < kPerKnot * static_cast<double>(knots.size()))
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
  c.vehicle_mass = vehicle.mass;
  c.map_file = options.map_file;
  c.map_sha256 = map.sha256();
  c.seed = path_options.seed;
  c.duration = trajectory->duration();
  c.tube = tube_of(mission, vehicle);
  c.clearance_asked = mission.clearance;
  c.clearance_horizon = map.max_distance();
  c.limits = mission.limits;
  if (auto ok = certify(*trajectory, vehicle, tilts, mission.limits.rotor_headroom, deadline, c); !ok)
    return Failure(ok.error());
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
  const auto map = DistanceMap::load(mission.test_bed, {.deadline = deadline});
  if (!map) return Failure(map.error());
  PlanOptions with_names = options;
  with_names.map_file = mission.test_bed.string();
  Result<TestBed> bed = TestBed{};
  if (!mission.description.empty() && !options.names) {
    bed = load_test_bed(mission.description);
    if (!bed) return Failure(bed.error());
    with_names.names = &*bed;
  }
  return plan_until(deadline, mission, *vehicle, *map, with_names);
}

Tube tube_of(const Mission& mission, const vehicle::Vehicle& vehicle) {
  constexpr double kLeast = 0.02;  // m, what laboratory motion capture and control leave of any reference
  const double room = std::max(mission.clearance, kLeast);
  return {
      mission.tracking_position.value_or(room),
      mission.tracking_attitude.value_or(std::min(kPi, room / std::max(kLeast, vehicle.bounding_radius())))};
}

Status check_match(const Certificate& c, const Mission& mission, const vehicle::Vehicle& vehicle) {
  std::string differs;
  const auto add = [&](const std::string& what) { differs += (differs.empty() ? "" : "; ") + what; };
  if (c.mission_sha256 != mission.sha256)
    add(c.mission == mission.name ? "the mission " + mission.file + " has changed since"
                                  : "it is a plan of the mission " + files::shown(c.mission) + ", not of " +
                                        files::shown(mission.name));
  if (std::abs(vehicle.mass - c.vehicle_mass) > 1e-9)
    add(text("its vehicle %s has %.4g kg, the one that shall fly, %s, %.4g kg",
             files::shown(c.vehicle).c_str(), c.vehicle_mass, files::shown(vehicle.name).c_str(),
             vehicle.mass));
  else if (c.vehicle_sha256 != vehicle.sha256)
    add(c.vehicle == vehicle.name
            ? "the vehicle " + files::shown(vehicle.name) + " differs (its file or --set)"
            : "its vehicle is " + files::shown(c.vehicle) + ", not " + files::shown(vehicle.name));
  const auto map = files::sha256_file(mission.test_bed);
  if (!map) return Failure(map.error());
  if (c.map_sha256 != *map) add("its map is not the one of the test bed " + mission.test_bed.string());
  if (differs.empty()) return {};
  return bad_input(
      "is not the plan of this flight: " + differs, "--plan",
      "Plan again with the same --vehicle and --set (omniflight plan MISSION), or leave --plan out");
}

std::string explain(const Result<Plan>& plan) {
  if (!plan) return "There is no plan. " + plan.error().text() + ".\n";
  const Certificate& c = plan->certificate;
  std::string out =
      text("Mission '%s' with '%s' (%.3f kg), alpha %.1f deg%s, %.2f s, seed %llu: %s.\n", c.mission.c_str(),
           c.vehicle.c_str(), c.vehicle_mass, to_degrees(c.alpha), c.alpha_searched ? " (searched)" : "",
           c.duration, static_cast<unsigned long long>(c.seed), c.verdict.c_str());
  if (c.alpha_highest > c.alpha_lowest)
    out += text("The tilt moves between %.1f and %.1f deg, at rest.\n", to_degrees(c.alpha_lowest),
                to_degrees(c.alpha_highest));
  out += text("It keeps at least %.3f m from every occupied voxel (least on the knots %.3f m at %.2f s).\n",
              c.clearance_asked, c.min_clearance, c.min_clearance_at);
  out += text("At most %.2f m/s, %.2f m/s2, %.1f deg/s; the rotors need %.0f %% of their range at %.2f s.\n",
              c.peak.speed, c.peak.acceleration, to_degrees(c.peak.rate), 100.0 * c.peak.rotor_load,
              c.peak.rotor_load_at);
  if (!c.reason.empty()) out += "Note: " + c.reason + "\n";
  return out;
}

}  // namespace omniflight::planning
