#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_planning/state_check.hpp"

namespace omniflight::planning {
namespace {

constexpr double kHorizon = 0.5;  // m beyond the vehicle's bounding sphere within which boxes are looked at
constexpr double kTolerance = 1e-6;

struct Box {
  Vec3 center;
  double half;
  double distance(const Vec3& p) const {
    return ((p - center).cwiseAbs().array() - half).max(0.0).matrix().norm();
  }
};

/// Exact distances of the sphere model to the octree's occupied leaves and to the edge of the known box.
class Boxes {
 public:
  explicit Boxes(const octomap::OcTree& tree) {
    tree.getMetricMin(lower_.x(), lower_.y(), lower_.z());
    tree.getMetricMax(upper_.x(), upper_.y(), upper_.z());
    for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf)
      if (tree.isNodeOccupied(*leaf))
        all_.push_back({Vec3(leaf.getX(), leaf.getY(), leaf.getZ()), 0.5 * leaf.getSize()});
  }

  double clearance(const Pose& pose, const VehicleSpheres& vehicle) {
    gather(pose.p_WB, vehicle.bounding_radius);
    double best = kHorizon;
    const Mat3 R = pose.q_WB.toRotationMatrix();
    for (const auto& group : vehicle.groups) {
      if (distance(pose.p_WB + R * group.bound.p_BS) - group.bound.radius >= best) continue;
      for (const auto& s : group.spheres) best = std::min(best, distance(pose.p_WB + R * s.p_BS) - s.radius);
    }
    return best;
  }

 private:
  /// Boxes that can matter near `center`; kept until the vehicle has moved 0.2 m.
  void gather(const Vec3& center, double radius) {
    if (gathered_ && (center - around_).norm() < 0.2) return;
    near_.clear();
    for (const Box& box : all_)
      if (box.distance(center) <= radius + kHorizon + 0.2) near_.push_back(box);
    around_ = center;
    gathered_ = true;
  }
  double distance(const Vec3& p) const {
    double best = std::min((p - lower_).minCoeff(), (upper_ - p).minCoeff());
    for (const Box& box : near_) best = std::min(best, box.distance(p));
    return best;
  }
  std::vector<Box> all_, near_;
  Vec3 lower_, upper_, around_ = Vec3::Zero();
  bool gathered_ = false;
};

Status check_waypoints(const Mission& mission, const Trajectory& trajectory, const std::string& where) {
  std::size_t next = 0;  // knots pass the waypoints in their order
  for (const Waypoint& waypoint : mission.waypoints) {
    const auto& knots = trajectory.knots();
    while (next < knots.size()) {
      const Reference& r = knots[next].reference;
      // a point that is flown through lies between two knots in general
      const double reach =
          waypoint.stop
              ? kTolerance
              : r.v_WB_W.norm() * (knots[std::min(next + 1, knots.size() - 1)].t - knots[next].t) + 1e-3;
      const double turn = waypoint.stop ? kTolerance : reach + r.w_WB_B.norm() * 0.02 + 1e-3;
      if ((r.p_WB - waypoint.pose.p_WB).norm() <= reach &&
          r.q_WB.angularDistance(waypoint.pose.q_WB) <= turn + 1e-5)
        break;
      ++next;
    }
    if (next == knots.size())
      return fail(ErrorCode::incomplete, waypoint.name + " of the mission is not reached in its turn", where,
                  "Plan again");
  }
  return {};
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

  const auto vehicle = vehicle::load_vehicle(c.vehicle_file);
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
  if (auto ok = check_waypoints(*mission, plan->trajectory, where); !ok) return Failure(ok.error());

  VerifyReport out;
  const auto& knots = plan->trajectory.knots();
  out.duration = plan->trajectory.duration();
  for (const auto& knot : knots)
    if (std::abs(knot.reference.alpha - c.alpha) > 1e-9)
      return reject("alpha is not constant along the trajectory");
  const auto rotors = allocation::RotorLoad::create(*vehicle, c.alpha);
  if (!rotors) return Failure(rotors.error());
  out.peak = peaks(knots, *rotors);
  const MotionLimits& limits = mission->limits;
  const struct {
    const char* what;
    double value, limit;
  } bounds[] = {{"speed [m/s]", out.peak.speed, limits.speed},
                {"acceleration [m/s2]", out.peak.acceleration, limits.acceleration},
                {"rate [rad/s]", out.peak.rate, limits.rate},
                {"angular acceleration [rad/s2]", out.peak.angular_acceleration, limits.angular_acceleration},
                {"share of the rotors' range", out.peak.rotor_load, 1.0 - limits.rotor_headroom}};
  for (const auto& b : bounds)
    if (!(b.value <= b.limit * (1.0 + kTolerance))) {
      char line[160];
      std::snprintf(line, sizeof line, "the %s reaches %.4g, %.4g is allowed", b.what, b.value, b.limit);
      return reject(line);
    }

  // Conservative advancement along the curve, with exact distances.
  const VehicleSpheres spheres = cover_with_spheres(*vehicle, c.alpha);
  Boxes boxes(*map->tree);
  out.min_clearance = kHorizon;
  double room = 0.0;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double speed = speed_bound(knots[k], knots[k + 1], spheres.bounding_radius);
    double t = knots[k].t;
    while (true) {
      if (room <= 0.0 || speed * (knots[k + 1].t - t) >= room) {
        t += room > 0.0 && speed > 0.0 ? room / speed : 0.0;
        const Reference r = plan->trajectory.sample(t);
        const double clearance = boxes.clearance({r.p_WB, r.q_WB}, spheres);
        ++out.poses;
        if (clearance < out.min_clearance) {
          out.min_clearance = clearance;
          out.min_clearance_at = t;
        }
        room = clearance - mission->clearance;
        if (room <= 1e-5) {
          char line[160];
          std::snprintf(line, sizeof line,
                        "the vehicle comes within %.4f m of the map's voxels at %.3f s, %.4f m are asked for",
                        clearance, t, mission->clearance);
          return reject(line);
        }
        continue;
      }
      room -= speed * (knots[k + 1].t - t);
      break;
    }
  }
  return out;
}

}  // namespace omniflight::planning
