// ODE: body and ball joints, solved by the exact stepper or the iterative one.
#include <memory>

#include "peers.hpp"

#ifdef OMNIFLIGHT_HAVE_ODE
#include <ode/ode.h>

namespace omniflight::benchmarks {
namespace {

struct World {
  dWorldID world = dWorldCreate();
  dJointGroupID joints = dJointGroupCreate(0);
  dBodyID body = nullptr;
  std::vector<Push> pushes;
  bool quick;

  World(const vehicle::Vehicle& v, int links, bool q)
      : pushes(hover_pushes(v, links ? kCableMass : 0)), quick(q) {
    dWorldSetGravity(world, 0, 0, -kGravity);
    dWorldSetAutoDisableFlag(world, 0);
    body = dBodyCreate(world);
    dMass m;
    const Mat3& I = v.inertia;
    dMassSetParameters(&m, v.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    dBodySetMass(body, &m);
    dBodySetPosition(body, 0, 0, 10);
    dBodySetAngularVel(body, 0.1, 0.2, 0.3);
    dBodyID above = body;
    const double length = kCableLength / kLinks;
    for (int k = 0; k < links; ++k) {
      dBodyID link = dBodyCreate(world);
      dMass lm;
      dMassSetCapsuleTotal(&lm, kCableMass / kLinks, 3, 0.003, length);
      dBodySetMass(link, &lm);
      dBodySetPosition(link, 0, 0, 10 - (k + 0.5) * length);
      dJointID joint = dJointCreateBall(world, joints);
      dJointAttach(joint, above, link);
      dJointSetBallAnchor(joint, 0, 0, 10 - k * length);
      above = link;
    }
  }
  World(const World&) = delete;
  ~World() {
    dJointGroupDestroy(joints);
    dWorldDestroy(world);
  }
  void run(int steps) {
    for (int k = 0; k < steps; ++k) {
      for (const Push& p : pushes)
        dBodyAddRelForceAtRelPos(body, p.force_B.x(), p.force_B.y(), p.force_B.z(), p.p_B.x(), p.p_B.y(),
                                 p.p_B.z());
      if (quick)
        dWorldQuickStep(world, kStep);
      else
        dWorldStep(world, kStep);
    }
  }
};

Contender make(const vehicle::Vehicle& v, int links, bool quick) {
  static const bool started = dInitODE2(0) != 0;
  (void)started;
  dAllocateODEDataForThread(dAllocateMaskAll);
  auto world = std::make_shared<World>(v, links, quick);
  return {quick ? "ODE quick" : "ODE", [world](int n) { world->run(n); }, 1, {}};
}

}  // namespace
Contender ode_free_body(const vehicle::Vehicle& v, bool quick) { return make(v, 0, quick); }
Contender ode_chain(const vehicle::Vehicle& v, bool quick) { return make(v, kLinks, quick); }
}  // namespace omniflight::benchmarks

#else
namespace omniflight::benchmarks {
Contender ode_free_body(const vehicle::Vehicle&, bool) {
  return {"ODE", {}, 1, "libode-dev is not installed"};
}
Contender ode_chain(const vehicle::Vehicle& v, bool quick) { return ode_free_body(v, quick); }
}  // namespace omniflight::benchmarks
#endif
