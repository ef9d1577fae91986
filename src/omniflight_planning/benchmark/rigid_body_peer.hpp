// Stock OMPL and FCL, set up as OMPL.app does: RRTConnect in SE(3), motions looked at every 1 % of the space;
// for a rigid body among triangles, both meshes are in trees of OBBRSS.
#pragma once

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <ompl/base/spaces/SE3StateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include "omniflight_planning/rigid_body.hpp"

namespace omniflight::planning {

namespace stock {

inline Pose read(const ompl::base::State* state) {
  const auto* s = state->as<ompl::base::SE3StateSpace::StateType>();
  const auto& q = s->rotation();
  return {Vec3(s->getX(), s->getY(), s->getZ()), Quat(q.w, q.x, q.y, q.z).normalized()};
}
inline void write(const Pose& pose, ompl::base::SE3StateSpace::StateType* s) {
  s->setXYZ(pose.p_WB.x(), pose.p_WB.y(), pose.p_WB.z());
  s->rotation().w = pose.q_WB.w(), s->rotation().x = pose.q_WB.x();
  s->rotation().y = pose.q_WB.y(), s->rotation().z = pose.q_WB.z();
}

/// The path that was found before `over` is true, or nothing; OMPL's random numbers go on from run to run;
/// `looks` counts the poses that were looked at.
template <class Hits>
std::vector<Pose> solve(const Vec3& lower, const Vec3& upper, const Pose& from, const Pose& to,
                        const Hits& hits, bool (*over)(), std::uint64_t& looks) {
  namespace ob = ompl::base;
  using Space = ob::SE3StateSpace;
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  auto space = std::make_shared<Space>();
  ob::RealVectorBounds bounds(3);
  for (unsigned k = 0; k < 3; ++k) bounds.setLow(k, lower[k]), bounds.setHigh(k, upper[k]);
  space->setBounds(bounds);
  ompl::geometric::SimpleSetup setup(space);
  looks = 0;
  setup.setStateValidityChecker([&](const ob::State* state) {
    ++looks;
    return setup.getSpaceInformation()->satisfiesBounds(state) && !hits(read(state));
  });
  setup.getSpaceInformation()->setStateValidityCheckingResolution(0.01);
  ob::ScopedState<Space> start(space), goal(space);
  write(from, start.get());
  write(to, goal.get());
  setup.setStartAndGoalStates(start, goal);
  setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(setup.getSpaceInformation()));
  setup.setup();
  std::vector<Pose> out;
  if (setup.solve(ob::PlannerTerminationCondition(over)) && setup.haveExactSolutionPath()) {
    auto& path = setup.getSolutionPath();
    for (std::size_t i = 0; i < path.getStateCount(); ++i)
      out.push_back(read(path.getState(static_cast<unsigned>(i))));
  }
  return out;
}

}  // namespace stock

class StockPlanner {
 public:
  explicit StockPlanner(const RigidBodyProblem& problem)
      : problem_(problem), world_(tree_of(problem.environment)), body_(tree_of(problem.body)) {}

  bool hits(const Pose& pose) const {
    body_.setTransform(pose.q_WB.toRotationMatrix(), pose.p_WB);
    body_.computeAABB();
    fcl::CollisionResultd result;
    return fcl::collide(&body_, &world_, fcl::CollisionRequestd(), result) > 0;
  }

  std::vector<Pose> solve(bool (*over)(), std::uint64_t& looks) const {
    return stock::solve(
        problem_.lower, problem_.upper, problem_.start, problem_.goal,
        [this](const Pose& pose) { return hits(pose); }, over, looks);
  }

 private:
  using Mesh = fcl::BVHModel<fcl::OBBRSSd>;

  static std::shared_ptr<Mesh> tree_of(const TriangleMesh& mesh) {
    auto out = std::make_shared<Mesh>();
    out->beginModel();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto t = mesh.corners(i);
      out->addTriangle(t[0], t[1], t[2]);
    }
    out->endModel();
    return out;
  }
  const RigidBodyProblem& problem_;
  fcl::CollisionObjectd world_;
  mutable fcl::CollisionObjectd body_;
};

}  // namespace omniflight::planning
