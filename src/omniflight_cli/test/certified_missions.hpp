// Random missions among the shipped test bed and random rooms, and the loops that fly their plans.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_campaign/many_flights.hpp"
#include "omniflight_control/leaning_gains.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::certified {

// Wind of the gusts: intensity a component [m/s], correlation time [s], drag area [m^2]. Its three components
// together exceed 5.5 times the intensity with a probability of 1e-6.
constexpr double kIntensity = 0.8, kCorrelation = 1.0, kArea = 0.05, kMostOfGust = 5.5;
constexpr double kAirDensity = 1.2;  // kg/m^3

/// A kind of mission: what flies, with what, and how.
struct Kind {
  const char* name;
  const char* vehicle;  ///< under configs/vehicles
  bool leans = false;   ///< into its motion (thrust_vector)
  bool tethered = false;
  bool tilting = false;    ///< the tilt moves to another angle at each waypoint
  bool in_flight = false;  ///< and it does so on the way there
  planning::Timing timing = planning::Timing::minimum_jerk;
  double tracking_position = 0.02, tracking_attitude = to_radians(4.0);  ///< m, rad, beside gusts
};

/// A map as file and as distance field.
struct Room {
  std::filesystem::path file;
  planning::DistanceMap map;
};

inline Result<Room> load_room(const std::filesystem::path& file) {
  auto map = planning::DistanceMap::load(file);
  if (!map) return Failure(map.error());
  return Room{file, std::move(*map)};
}

/// A room of 5 x 4 x 3 m with columns, beams and boxes; round the anchor of the tether nothing stands.
inline Result<Room> random_room(Random& random, const std::filesystem::path& file) {
  using Shape = planning::Primitive::Kind;
  planning::TestBed bed;
  bed.name = "random room";
  bed.lower = Vec3(-2.5, -2.0, -0.1), bed.upper = Vec3(2.5, 2.0, 3.0);
  bed.primitives.push_back({Shape::box, "floor", Vec3(0, 0, -0.05), Vec3(5, 4, 0.09), 0});
  const auto place = [&] {
    Vec3 p;
    do
      for (int k = 0; k < 3; ++k) p[k] = random.uniform(bed.lower[k], bed.upper[k]);
    while (p.head<2>().norm() < 0.6);
    return p;
  };
  for (int k = 0; k < 4; ++k) {
    const Vec3 p = place(), q = place();
    bed.primitives.push_back(
        {Shape::cylinder, "column", Vec3(p.x(), p.y(), 0), Vec3(p.x(), p.y(), random.uniform(1, 3)), 0.06});
    bed.primitives.push_back({Shape::capsule, "beam", p, Vec3(p.x(), q.y(), p.z()), 0.04});
    bed.primitives.push_back(
        {Shape::box, "box", q, Vec3(random.uniform(0.1, 0.6), random.uniform(0.1, 0.6), 0.3), 0});
  }
  const auto tree = planning::make_octree(bed);
  if (!tree) return Failure(tree.error());
  const auto bytes = planning::octree_bytes(**tree);
  if (!bytes) return Failure(bytes.error());
  if (auto ok = files::write_file_atomic(file.string(), *bytes); !ok) return Failure(ok.error());
  return load_room(file);
}

inline double slowest_motor(const vehicle::Vehicle& vehicle) {
  double out = 0;
  for (const vehicle::Rotor& r : vehicle.rotors) out = std::max(out, r.time_constant);
  return out;
}

inline control::ControllerConfig gains_of(const vehicle::Vehicle& vehicle, bool leans) {
  return leans ? control::leaning_gains(slowest_motor(vehicle)) : control::ControllerConfig{};
}

/// Whether a tether, if there is one, may lead there at all: within its cone about the vertical.
inline bool in_reach(const planning::Mission& m, const Vec3& p) {
  if (!m.tether) return true;
  const Vec3 way = p - m.tether->anchor_W;
  return way.norm() < m.tether->length && way.z() > way.norm() * std::cos(to_radians(55));
}

/// A mission of `kind` between random poses of the room.
inline planning::Mission random_mission(Random& random, const Kind& kind, const planning::DistanceMap& map,
                                        const vehicle::Vehicle& vehicle) {
  planning::Mission m;
  m.name = kind.name;
  m.budget_s = 2.0;
  m.clearance = 0.03;
  m.limits.rotor_headroom = 0.15;
  m.timing = kind.timing;
  m.tracking_position = kind.tracking_position;
  m.tracking_attitude = kind.tracking_attitude;
  m.tracking_in_margin = true;
  const bool tilts = vehicle.tilt.kind != vehicle::TiltKind::none;
  m.alpha = to_radians(tilts ? 45 : 0);
  const double wind = kMostOfGust * kIntensity;
  double unknown = 0.5 * kAirDensity * kArea * wind * wind;  // N, of which the law knows nothing
  if (kind.tethered) {
    const Vec3 anchor(0, 0, map.distance(Vec3(0, 0, 0.5)) > 0.0 ? 0.05 : 0.62);  // the floor, or a counter
    m.tether = planning::Tether{.anchor_W = anchor, .length = 4.0, .linear_mass = 0.05};
    m.tether->cone = to_radians(80);
    m.tether->twist = to_radians(200);
    unknown += 2.0 * m.tether->linear_mass * kGravity;  // two metres of it
  }
  const bool leans = kind.leans;
  m.gust = planning::Gust{.force = unknown,
                          .compliance = 1.0 / (vehicle.mass * gains_of(vehicle, leans).kp.minCoeff())};
  for (const char* name : {"start", "via", "goal"}) {
    planning::Waypoint w;
    w.name = name;
    do
      for (int k = 0; k < 3; ++k) w.pose.p_WB[k] = random.uniform(map.lower()[k], map.upper()[k]);
    while (map.distance(w.pose.p_WB) < 0.3 || !in_reach(m, w.pose.p_WB));
    const double heading = random.uniform(-1.2, 1.2);
    const double roll = random.uniform(-0.5, 0.5), pitch = random.uniform(-0.5, 0.5);
    w.pose.q_WB =
        leans ? from_roll_pitch_yaw(Vec3(0, 0, heading)) : from_roll_pitch_yaw(Vec3(roll, pitch, heading));
    if (leans) w.heading = heading;
    if (kind.tilting && !m.waypoints.empty()) w.alpha = to_radians(random.uniform(35, 55));
    w.tilt_in_flight = kind.in_flight && w.alpha.has_value();
    m.waypoints.push_back(w);
  }
  return m;
}

inline campaign::Loop loop_of(const planning::Plan& plan, const vehicle::Vehicle& vehicle) {
  campaign::Loop loop;
  loop.vehicle = loop.believed = vehicle;
  loop.allocator = allocation::AllocatorConfig::case_a();
  loop.allocator.tilt_mode = allocation::TiltMode::fixed;
  loop.allocator.initial_tilt = loop.plant.initial_alpha = plan.certificate.alpha;
  if (plan.certificate.leans) loop.law = "thrust_vector";
  loop.trajectory = plan.trajectory;
  loop.duration = loop.hold + loop.settle + plan.trajectory.duration() + 1.0;
  const Reference& start = plan.trajectory.knots().front().reference;
  loop.plant.initial.p_WB = start.p_WB;
  loop.plant.initial.q_WB = start.q_WB;
  return loop;
}

/// The law as `fly` sets it for the plan.
inline control::LawConfig law_of(const planning::Plan& plan, const vehicle::Vehicle& vehicle) {
  control::LawConfig law;
  law.gains = gains_of(vehicle, plan.certificate.leans);
  if (!plan.certificate.leans) return law;
  law.thrust_axis_B = plan.certificate.thrust_axis_B;
  law.max_lean = plan.certificate.limits.lean + to_radians(10.0);
  return law;
}

/// What flights of one kind came to.
struct Score {
  int plans = 0, drawn = 0, flights = 0;
  int ended = 0, hit = 0, outside = 0, saturated = 0, tether = 0;
  double least_clearance = 1, least_headroom = 1;      ///< m, share of a rotor's range
  double worst_position = 0, worst_attitude = 0;       ///< share of the tube
  double planned_clearance = 1, planned_headroom = 1;  ///< least of the certificates
  double way = 0, time = 0;                            ///< m planned, s flown
  std::string first_fault;                             ///< how to see it again
  void fault(const std::string& what) {
    if (first_fault.empty()) first_fault = what;
  }
};

}  // namespace omniflight::certified
