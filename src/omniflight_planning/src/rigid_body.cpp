#include "omniflight_planning/rigid_body.hpp"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>

#include "convex_scene.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "text.hpp"
#include "triangle_tree.hpp"

namespace omniflight::planning {
namespace {

constexpr double kBodyRadius = 0.5;  // m, scaled
constexpr double kBeyond = 0.15;     // m, of the map beyond what the body can reach
/// Where parts tell what is valid, the field is only asked where gaps are, and making it costs more than most
/// searches.
constexpr double kVoxelsBesideParts = 0.1;
/// Of the body's radius: larger triangles are halved. Their spheres fit closer then, but every piece is
/// looked up in the field and asked for among the triangles: at 0.2 a rod of 12 triangles became 220 pieces,
/// and a pose took three times as long.
constexpr double kSphereShare = 1.0;
constexpr double kLeastResolution = 0.01, kMostResolution = 1.0;  // m

Failure bad_problem(const std::string& why, const std::string& field) {
  return bad_input(why, field, "Give numbers in the unit of the meshes");
}

std::string coordinates(const Vec3& p) { return text("(%.6g, %.6g, %.6g)", p.x(), p.y(), p.z()); }

/// The edge of a voxel [m] with which a box holds about so many of them.
double resolution_of(const Vec3& size, double voxels) {
  double out = std::clamp(std::cbrt(size.prod() / voxels), kLeastResolution, kMostResolution);
  while ((size / out + Vec3::Constant(2.0)).prod() > static_cast<double>(kMaxMapVoxels)) out *= 1.1;
  return out;
}

Status check_problem(const RigidBodyProblem& p) {
  for (const bool is_start : {true, false}) {
    const Pose& pose = is_start ? p.start : p.goal;
    const char* field = is_start ? "start" : "goal";
    if (!is_finite(pose))
      return bad_problem("the pose is not finite or its quaternion is no unit one", field);
    if ((pose.p_WB - p.lower).minCoeff() < 0.0 || (p.upper - pose.p_WB).minCoeff() < 0.0)
      return bad_problem(coordinates(pose.p_WB) + " lies outside of the box from " + coordinates(p.lower) +
                             " to " + coordinates(p.upper),
                         field);
  }
  if (!p.lower.allFinite() || !p.upper.allFinite() || (p.upper - p.lower).minCoeff() <= 0.0)
    return bad_problem("the box has no inside: " + coordinates(p.lower) + " to " + coordinates(p.upper),
                       "bounds");
  if (p.environment.triangles.empty() || p.body.triangles.empty())
    return bad_problem("environment or body has no triangle", "mesh");
  return {};
}

/// Those of the solids that hold no point of the others, at any of these poses; the surfaces of the rest are
/// triangles: a body that begins inside of an obstacle may move there.
void open_solids(MeshParts& body, MeshParts& world, const std::vector<Pose>& poses) {
  const auto open = [](MeshParts& parts, const auto& holds_any) {
    for (std::size_t i = parts.solids.size(); i-- > 0;) {
      if (!holds_any(parts.solids[i])) continue;
      const auto& surface = parts.solids[i].surface;
      parts.triangles.insert(parts.triangles.end(), surface.begin(), surface.end());
      parts.solids.erase(parts.solids.begin() + static_cast<std::ptrdiff_t>(i));
    }
  };
  std::vector<Vec3> body_points, world_points;
  const auto collect = [](const MeshParts& parts, std::vector<Vec3>& points) {
    for (const ConvexPart& part : parts.solids) points.push_back(part.points.front());
    for (const Triangle& t : parts.triangles) points.push_back(t[0]);
  };
  collect(body, body_points), collect(world, world_points);
  const auto any = [&](const std::vector<Vec3>& points, const ConvexPart& part, const auto& place) {
    for (const Pose& pose : poses)
      for (const Vec3& p : points)
        if (part.holds(place(pose, p))) return true;
    return false;
  };
  open(world, [&](const ConvexPart& part) {
    return any(body_points, part, [](const Pose& at, const Vec3& p) { return Vec3(at.p_WB + at.q_WB * p); });
  });
  open(body, [&](const ConvexPart& part) {
    return any(world_points, part,
               [](const Pose& at, const Vec3& p) { return Vec3(at.q_WB.conjugate() * (p - at.p_WB)); });
  });
}

std::shared_ptr<const ConvexScene> convex_scene(const TriangleMesh& body, const TriangleMesh& world,
                                                const std::vector<Pose>& poses) {
  MeshParts of_body = parts_of(body);
  MeshParts of_world = parts_of(world);
  open_solids(of_body, of_world, poses);
  return std::make_shared<const ConvexScene>(of_body, of_world);
}

}  // namespace

Result<RigidBodyScene> RigidBodyScene::create(const RigidBodyProblem& problem,
                                              const RigidBodyOptions& options) {
  if (auto ok = check_problem(problem); !ok) return Failure(ok.error());
  RigidBodyScene out;
  double radius = 0.0;
  for (const Vec3& p : problem.body.vertices) radius = std::max(radius, p.norm());
  if (!(radius > 0.0)) return bad_problem("the body is a point", "body");
  out.scale_ = kBodyRadius / radius;
  out.center_ = 0.5 * (problem.lower + problem.upper);
  out.start_ = problem.start, out.goal_ = problem.goal;
  TriangleMesh body = problem.body, world = problem.environment;
  body.scale(out.scale_);
  world.move(-out.center_);
  world.scale(out.scale_);
  const Vec3 half = 0.5 * out.scale_ * (problem.upper - problem.lower);
  const Vec3 reach = half + Vec3::Constant(kBodyRadius + kBeyond);
  const auto parts = convex_scene(body, world, {out.inside(out.start_), out.inside(out.goal_)});
  const double voxels = std::min(options.voxels, 1e7) * kVoxelsBesideParts;
  const double resolution = resolution_of(2.0 * reach, voxels);
  // what lies outside of the body's reach is left out, with a voxel to spare
  const Vec3 kept = reach + Vec3::Constant(2.0 * resolution);
  std::vector<Triangle> obstacles;
  TriangleMesh near = world;
  near.triangles.clear();
  for (std::size_t i = 0; i < world.triangles.size(); ++i) {
    if (!touches_box(world.corners(i), Vec3::Zero(), kept)) continue;
    obstacles.push_back(world.corners(i));
    near.triangles.push_back(world.triangles[i]);
  }
  if (near.triangles.empty())
    return bad_problem("no triangle of the environment is in reach: there would be no obstacle at all",
                       "env");
  const auto tree = make_octree(
      near, "env",
      {.resolution = resolution, .box = std::array{Vec3(-reach), reach}, .deadline = options.path.deadline});
  if (!tree) return Failure(tree.error());
  auto map = DistanceMap::create(**tree, "", {.deadline = options.path.deadline});
  if (!map) return Failure(map.error());
  out.map_ = std::make_unique<const DistanceMap>(std::move(*map));
  out.check_ = std::make_unique<const StateCheck>(
      StateCheck(*out.map_, cover_with_spheres(body, kSphereShare), nullptr, 0.0, 0.0)
          .among({.obstacles = std::make_shared<const TriangleTree>(std::move(obstacles)),
                  .parts = parts,
                  .lower = -half,
                  .upper = half,
                  .looks = std::make_shared<std::atomic<std::uint64_t>>(0)}));
  return out;
}

PathResult<std::vector<Pose>> RigidBodyScene::plan(const PathOptions& options) const {
  const Pose start = inside(start_), goal = inside(goal_);
  for (const bool is_start : {true, false}) {
    const Pose& given = is_start ? start_ : goal_;
    if (!valid(given))
      return tl::unexpected<PathProblem>({is_start ? PathFailure::start_occupied : PathFailure::goal_occupied,
                                          std::string(is_start ? "the start " : "the goal ") +
                                              coordinates(given.p_WB) + " touches the environment"});
  }
  auto path = find_path(*check_, start, goal, options);
  if (!path)
    return tl::unexpected<PathProblem>(
        {PathFailure::no_path_in_time, "no path was found from " + coordinates(start_.p_WB) + " to " +
                                           coordinates(goal_.p_WB) + text(" in %.3g s", options.budget_s)});
  for (Pose& pose : *path) pose = outside(pose);
  path->front() = start_, path->back() = goal_;
  return path;
}

}  // namespace omniflight::planning
