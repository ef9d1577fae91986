#include <algorithm>
#include <cmath>
#include <cstdio>

#include "actuation.hpp"
#include "octree_boxes.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/flatness.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_planning/state_check.hpp"
#include "text.hpp"
#include "tilt.hpp"
#include "tilting_check.hpp"
#include "tilts.hpp"
#include "upright.hpp"

namespace omniflight::planning {
namespace {

constexpr double kTolerance = 1e-6;

/// What an attitude still has to turn to be the waypoint's [rad]. Of a vehicle that leans into its motion the
/// heading counts: the lean is judged with the rotors.
double turn_left(const Reference& r, const Waypoint& waypoint, const std::optional<FlatVehicle>& flat) {
  if (!flat) return r.q_WB.angularDistance(waypoint.pose.q_WB);
  const Quat swing =
      shortest_rotation(waypoint.pose.q_WB * flat->thrust_axis_B, r.q_WB * flat->thrust_axis_B);
  return r.q_WB.angularDistance(swing * waypoint.pose.q_WB);
}

Status check_waypoints(const Mission& mission, const Trajectory& trajectory,
                       const std::optional<FlatVehicle>& flat, const std::string& where) {
  std::size_t next = 0;  // knots pass the waypoints in their order
  double alpha = trajectory.knots().front().reference.alpha;
  const Vec3 centre = flat ? flat->p_BBcm : Vec3(Vec3::Zero());
  for (const Waypoint& waypoint : mission.waypoints) {
    alpha = waypoint.alpha.value_or(alpha);
    const auto& knots = trajectory.knots();
    while (next < knots.size()) {
      const Reference& r = knots[next].reference;
      // a point that is flown through lies between two knots in general
      const double reach =
          waypoint.stop
              ? kTolerance
              : r.v_WB_W.norm() * (knots[std::min(next + 1, knots.size() - 1)].t - knots[next].t) + 1e-3;
      const double turn = waypoint.stop ? kTolerance : reach + r.w_WB_B.norm() * 0.02 + 1e-3;
      // a leaning vehicle flies its centre of mass through the point
      const Vec3 way = r.p_WB + r.q_WB * centre - waypoint.pose.p_WB - waypoint.pose.q_WB * centre;
      if (way.norm() <= reach && turn_left(r, waypoint, flat) <= turn + 1e-5 &&
          std::abs(r.alpha - alpha) <= kTolerance)
        break;
      ++next;
    }
    if (next == knots.size())
      return fail(ErrorCode::incomplete, waypoint.name + " of the mission is not reached in its turn", where,
                  "Plan again");
  }
  return {};
}

/// The tilt moves within its range and no faster than its servo, and only while the vehicle rests unless the
/// mission moves it in flight.
Status check_move(const vehicle::Vehicle& vehicle, const std::vector<TrajectoryKnot>& knots,
                  const TiltPiece& piece, bool in_flight) {
  char line[160];
  const Reference& place = knots[piece.first].reference;
  for (std::size_t k = piece.first; k <= piece.last; ++k) {
    const Reference& r = knots[k].reference;
    const bool rests =
        !((r.p_WB - place.p_WB).norm() > kTolerance || r.q_WB.angularDistance(place.q_WB) > 1e-5 ||
          r.v_WB_W.norm() + r.w_WB_B.norm() + r.a_WB_W.norm() + r.dw_WB_B.norm() > kTolerance);
    if (!rests && !in_flight) {
      std::snprintf(line, sizeof line, "the tilt moves while the vehicle does, at %.2f s", knots[k].t);
      return fail(ErrorCode::incomplete, line);
    }
    if (r.alpha < vehicle.tilt.min - 1e-9 || r.alpha > vehicle.tilt.max + 1e-9) {
      std::snprintf(line, sizeof line, "the tilt leaves its range at %.2f s: %.2f deg", knots[k].t,
                    to_degrees(r.alpha));
      return fail(ErrorCode::incomplete, line);
    }
    if (k == piece.first) continue;
    const double rate = std::abs(r.alpha - knots[k - 1].reference.alpha) / (knots[k].t - knots[k - 1].t);
    if (rate > vehicle.tilt.rate * (1 + kTolerance)) {
      std::snprintf(line, sizeof line, "the tilt moves at %.1f deg/s at %.2f s, the servo does %.1f",
                    to_degrees(rate), knots[k].t, to_degrees(vehicle.tilt.rate));
      return fail(ErrorCode::incomplete, line);
    }
  }
  return {};
}

/// Way [m] that every vehicle point may move before the tether violates a limit, and which limit it is where
/// that is no more than `least` [m].
struct TetherRoom {
  double room = 0.0;
  std::optional<TetherConflict> conflict;
};
TetherRoom room_of_tether(Tether tether, double clearance, double least, const OctreeBoxes& boxes,
                          const Reference& r, const VehicleSpheres& spheres) {
  const double reach = tether.reach(spheres.bounding_radius);
  const Vec3 end = tether.attachment_W(r.p_WB, r.q_WB);
  const double near = boxes.segment_distance(loose_from(tether, end), end, kBoxHorizon);
  TetherRoom out;
  out.room = std::min(tether_slack(tether, reach, r.p_WB, r.q_WB), near - clearance);
  if (out.room > least) return out;
  tether.reserve += least;
  out.conflict = tether_conflict(tether, near, clearance + least, reach, r.p_WB, r.q_WB);
  return out;
}

/// That a plan that begins in flight begins with the state of its certificate, to the jerk.
Status check_join(const FlightState& from, const std::vector<TrajectoryKnot>& knots) {
  const Reference &a = from.reference, &b = knots.front().reference;
  if ((a.p_WB - b.p_WB).norm() > kTolerance || a.q_WB.angularDistance(b.q_WB) > 1e-5 ||
      (a.v_WB_W - b.v_WB_W).norm() > kTolerance || (a.w_WB_B - b.w_WB_B).norm() > kTolerance ||
      (a.a_WB_W - b.a_WB_W).norm() > kTolerance || (a.dw_WB_B - b.dw_WB_B).norm() > kTolerance ||
      std::abs(a.alpha - b.alpha) > kTolerance)
    return fail(ErrorCode::incomplete, "the plan does not begin with the state in flight that it tells");
  const double jump = knots.size() < 2 ? 0.0 : (jerk_between(knots[0], knots[1], 0.0) - from.j_WB_W).norm();
  // the quintic between knots has the jerk of the curve to the third power of the knots' distance
  if (jump > 1e-3 * (1.0 + from.j_WB_W.norm()))
    return fail(ErrorCode::incomplete,
                text("the jerk jumps by %.3g m/s3 where the plan begins in flight", jump));
  return {};
}

/// The errors that the plan keeps in its margin, from the mission and the file where they were measured.
Result<Tube> tube_again(const Certificate& c, const Mission& mission, const vehicle::Vehicle& vehicle) {
  auto tube = tube_for(mission, vehicle, c.tube.file);
  if (!tube) return tube;
  if (tube->sha256 != c.tube.sha256)
    return fail(ErrorCode::incomplete, "the measured errors in " + c.tube.file + " have changed");
  if (c.tube.in_margin != tube->in_margin ||
      (c.tube.in_margin && (std::abs(c.tube.position - tube->position) > kTolerance ||
                            std::abs(c.tube.attitude - tube->attitude) > kTolerance)))
    return fail(ErrorCode::incomplete, "the certificate's tube is not what mission and file tell");
  return tube;
}

}  // namespace

Result<VerifyReport> verify(const std::filesystem::path& dir) {
  const auto plan = read_plan(dir);
  if (!plan) return Failure(plan.error());
  const Certificate& c = plan->certificate;
  const std::string where = (dir / "certificate.json").string();
  const auto reject = [&](const std::string& why) {
    return fail(ErrorCode::incomplete, why, where, "Plan the mission again");
  };
  if (c.verdict != "certified")
    return reject("the certificate's own verdict is '" + c.verdict + "': " + c.reason);

  auto vehicle = vehicle::load_vehicle(c.vehicle_file, c.vehicle_set);
  if (!vehicle) return Failure(vehicle.error());
  if (vehicle->sha256 != c.vehicle_sha256)
    return reject("the vehicle '" + c.vehicle_file + "' has changed since the plan was made");
  if (std::abs(vehicle->mass - c.vehicle_mass) > 1e-9)
    return reject("the plan was made for another mass of '" + c.vehicle_file + "'");
  const auto map = read_octree(c.map_file);
  if (!map) return Failure(map.error());
  if (map->sha256 != c.map_sha256)
    return reject("the map " + c.map_file + " has changed since the plan was made");
  const auto mission = load_mission(c.mission_file);
  if (!mission) return Failure(mission.error());
  if (mission->sha256 != c.mission_sha256)
    return reject("the mission " + c.mission_file + " has changed since the plan was made");
  const LoadedVehicle loads = with_loads(*mission, *vehicle);
  const vehicle::Vehicle &loaded = loads.with_tether, &bare = loads.without_tether;
  const auto tube = tube_again(c, *mission, bare);
  if (!tube)
    return tube.error().code == ErrorCode::incomplete ? reject(tube.error().message) : Failure(tube.error());
  const auto& knots = plan->trajectory.knots();
  std::optional<FlatVehicle> flat;
  if (c.leans) {
    const auto found = flat_vehicle(bare, knots.front().reference.alpha);
    if (!found) return Failure(found.error());
    if (!*found || ((*found)->thrust_axis_B - c.thrust_axis_B).norm() > kTolerance)
      return reject("the plan leans into its motion, which is not how this vehicle moves");
    flat = *found;
  }
  auto asked = with_headings(*mission, bare);
  if (!asked) return Failure(asked.error());
  if (c.from) {  // the mission's start is what it has left
    if (auto ok = check_join(*c.from, knots); !ok) return reject(ok.error().message);
    asked->waypoints.erase(asked->waypoints.begin());
  }
  if (auto ok = check_waypoints(*asked, plan->trajectory, flat, where); !ok) return Failure(ok.error());

  VerifyReport out;
  out.duration = plan->trajectory.duration();
  if (std::abs(knots.front().reference.alpha - c.alpha) > 1e-9)
    return reject("the trajectory does not begin at the certificate's alpha");
  const std::vector<TiltPiece> pieces = tilt_pieces(knots);
  const bool in_flight = std::any_of(mission->waypoints.begin(), mission->waypoints.end(),
                                     [](const Waypoint& w) { return w.tilt_in_flight; });
  for (const TiltPiece& piece : pieces) {
    if (piece.moves) {
      if (auto ok = check_move(bare, knots, piece, in_flight); !ok) return reject(ok.error().message);
      const auto most = peaks_while_tilting(loaded, knots, piece, mission->limits.rotor_headroom);
      if (!most) return Failure(most.error());
      out.peak = larger(out.peak, *most, 0.0);
    } else {
      const auto rotors =
          Rotors::create(loaded, knots[piece.first].reference.alpha, mission->limits.rotor_headroom);
      if (!rotors) return Failure(rotors.error());
      const auto from = knots.begin() + static_cast<std::ptrdiff_t>(piece.first);
      const auto to = knots.begin() + static_cast<std::ptrdiff_t>(piece.last) + 1;
      const std::vector<TrajectoryKnot> part(from, to);
      if (auto ok = check_actuation(part, rotors->load()); !ok) return reject(ok.error().message);
      MotionPeaks most = peaks(part, *rotors);
      if (flat) most.lean = largest_lean(part, *flat);
      out.peak = larger(out.peak, most, 0.0);
    }
  }
  if (mission->tether) {
    const auto load = load_alone(bare, knots);
    if (!load) return Failure(load.error());
    out.peak.rotor_load = std::max(out.peak.rotor_load, *load);
    if (const auto twisted = twist_conflict(*mission->tether, tether_use(*mission->tether, knots)))
      return reject(*twisted);
  }
  const MotionLimits& limits = mission->limits;
  const struct {
    const char* what;
    double value, limit;
  } bounds[] = {{"speed [m/s]", out.peak.speed, limits.speed},
                {"acceleration [m/s2]", out.peak.acceleration, limits.acceleration},
                {"rate [rad/s]", out.peak.rate, limits.rate},
                {"angular acceleration [rad/s2]", out.peak.angular_acceleration, limits.angular_acceleration},
                {"lean of the thrust axis [rad]", out.peak.lean, limits.lean},
                {"share of the rotors' range", out.peak.rotor_load, 1.0 - limits.rotor_headroom}};
  for (const auto& b : bounds)
    if (!(b.value <= b.limit * (1.0 + kTolerance))) {
      char line[160];
      std::snprintf(line, sizeof line, "the %s reaches %.4g, %.4g is allowed", b.what, b.value, b.limit);
      return reject(line);
    }

  if (const ThrustRate& rate = out.peak.thrust_rate;
      !(rate.share <= (1.0 - limits.rotor_headroom) * (1.0 + kTolerance))) {
    const Vec3 p = plan->trajectory.sample(out.peak.thrust_rate_at).p_WB;
    return reject(text(
        "rotor %d needs %.4g of the rate of thrust that its lag allows, %.4g is allowed, at "
        "%.2f s with the vehicle at (%.3f, %.3f, %.3f) m",
        rate.rotor, rate.share, 1.0 - limits.rotor_headroom, out.peak.thrust_rate_at, p.x(), p.y(), p.z()));
  }

  OctreeBoxes boxes(*map->tree, mission->zones);
  out.min_clearance = kBoxHorizon;
  const auto look = [&](double t, const VehicleSpheres& spheres, double least) -> Result<double> {
    const Reference r = plan->trajectory.sample(t);
    const double clearance = boxes.clearance({r.p_WB, r.q_WB}, spheres);
    ++out.poses;
    const double margin = margin_of(*tube, spheres, mission->tether), needed = mission->clearance + margin;
    double room = clearance - needed;
    if (mission->tether) {
      Tether tether = *mission->tether;
      tether.reserve = margin;
      const TetherRoom left = room_of_tether(tether, needed, least, boxes, r, spheres);
      room = std::min(room, left.room);
      if (left.conflict)
        return reject(text("%s, at %.3f s with the vehicle at (%.3f, %.3f, %.3f) m",
                           left.conflict->words.c_str(), t, r.p_WB.x(), r.p_WB.y(), r.p_WB.z()));
    }
    if (clearance < out.min_clearance) out.min_clearance = clearance, out.min_clearance_at = t;
    if (room > least) return room;
    char line[160];
    std::snprintf(line, sizeof line,
                  "the vehicle comes within %.4f m of the map's voxels at %.3f s, %.4f m are asked for",
                  clearance, t, needed);
    return reject(line);
  };
  for (const TiltPiece& piece : pieces) {
    // Conservative advancement along the curve, with exact distances; at the tilt of the moment where it
    // moves.
    VehicleSpheres spheres = cover_with_spheres(bare, knots[piece.first].reference.alpha);
    double room = 0.0;
    for (std::size_t k = piece.first; k < piece.last; ++k) {
      if (piece.moves) spheres = cover_with_spheres(bare, knots[k].reference.alpha);
      const double rims = rim_travel(bare, knots[k + 1].reference.alpha - knots[k].reference.alpha);
      const double held = spheres.bounding_radius + rims;
      const double radius = mission->tether ? mission->tether->reach(held) : held;
      const double speed =
          speed_bound(knots[k], knots[k + 1], radius) + rim_speed(bare, knots[k], knots[k + 1]);
      double t = knots[k].t;
      while (room <= 0.0 || speed * (knots[k + 1].t - t) >= room) {
        t += room > 0.0 && speed > 0.0 ? room / speed : 0.0;
        if (piece.moves) spheres = cover_with_spheres(bare, plan->trajectory.sample(t).alpha);
        const auto left = look(t, spheres, 1e-5);
        if (!left) return Failure(left.error());
        room = *left;
      }
      room -= speed * (knots[k + 1].t - t);
    }
  }
  return out;
}

}  // namespace omniflight::planning
