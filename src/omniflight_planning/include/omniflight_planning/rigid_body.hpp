// A rigid body in SE(3) between two poses among the triangles of a mesh: the problems of OMPL.app.
#pragma once

#include <memory>
#include <vector>

#include "omniflight_planning/mesh.hpp"
#include "omniflight_planning/planner.hpp"

namespace omniflight::planning {

/// All lengths in one unit, whatever it is.
struct RigidBodyProblem {
  TriangleMesh environment;
  TriangleMesh body;  ///< in its own frame, about whose origin it turns
  Pose start, goal;
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();  ///< box that the origin of the body may be in
};

struct RigidBodyOptions {
  PathOptions path = {};
  double voxels = 1e6;  ///< of the distance field, at most 1e7
};

/// A problem made ready for questions. Inside, lengths are scaled so that the body's bounding radius is 0.5
/// m, for which the planner's lengths were chosen. A pose is free when no triangle of the body is nearer than
/// 0.4 thousandths of that radius to one of the environment. Surfaces count: a body whose start or goal is
/// inside of a closed surface as a whole is free there, and cannot leave. The inside of a closed convex
/// surface that holds neither of them is not free (ADR 24).
class RigidBodyScene {
 public:
  /// Refuses numbers that are not finite, boxes without inside, and a start or goal outside of the box.
  static Result<RigidBodyScene> create(const RigidBodyProblem& problem, const RigidBodyOptions& options = {});

  /// By separating axes of convex parts. Certified: whatever is called free is.
  bool valid(const Pose& pose) const { return check().valid(inside(pose)); }
  /// The whole motion of interpolate(a, b, .), not samples of it.
  bool motion_valid(const Pose& a, const Pose& b) const { return check().motion_valid(inside(a), inside(b)); }
  /// Lower bound of the distance of the surfaces, exact to the scaled 0.1 mm where it is below 0.04 m scaled.
  double room(const Pose& pose) const { return check().room(inside(pose)) / scale_; }

  /// Poses from start to goal, as of find_path; messages have the problem's unit.
  PathResult<std::vector<Pose>> plan(const PathOptions& options) const;

  std::uint64_t looks() const { return *check_->space()->looks; }  ///< poses looked at so far
  const StateCheck& check() const { return *check_; }
  double scale() const { return scale_; }  ///< m a unit of the problem

 private:
  RigidBodyScene() = default;
  Pose inside(const Pose& pose) const { return {scale_ * (pose.p_WB - center_), pose.q_WB}; }
  Pose outside(const Pose& pose) const { return {pose.p_WB / scale_ + center_, pose.q_WB}; }

  double scale_ = 1.0;
  Vec3 center_ = Vec3::Zero();
  Pose start_, goal_;  // of the problem
  std::unique_ptr<const DistanceMap> map_;
  std::unique_ptr<const StateCheck> check_;
};

}  // namespace omniflight::planning
