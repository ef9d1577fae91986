// Bullet: rigid bodies without collision shapes in contact, point-to-point constraints.
#include <memory>

#include "peers.hpp"

#ifdef OMNIFLIGHT_HAVE_BULLET
#include <btBulletDynamicsCommon.h>

namespace omniflight::benchmarks {
namespace {

struct World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btSphereShape shape{0.003};
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> constraints;
  std::vector<Push> pushes;

  World(const vehicle::Vehicle& v, int links) : pushes(hover_pushes(v, links ? kCableMass : 0)) {
    world.setGravity(btVector3(0, 0, -kGravity));
    add(v.mass, btVector3(v.inertia(0, 0), v.inertia(1, 1), v.inertia(2, 2)), 10);
    bodies[0]->setAngularVelocity(btVector3(0.1, 0.2, 0.3));
    const double length = kCableLength / kLinks, m = kCableMass / kLinks;
    for (int k = 0; k < links; ++k) {
      add(m, btVector3(m * length * length / 12, m * length * length / 12, m * 4.5e-6),
          10 - (k + 0.5) * length);
      const btVector3 in_above(0, 0, k == 0 ? 0.0 : -0.5 * length), in_below(0, 0, 0.5 * length);
      constraints.push_back(std::make_unique<btPoint2PointConstraint>(*bodies[bodies.size() - 2],
                                                                      *bodies.back(), in_above, in_below));
      world.addConstraint(constraints.back().get(), true);
    }
  }
  World(const World&) = delete;
  ~World() {
    for (auto& c : constraints) world.removeConstraint(c.get());
    for (auto& b : bodies) world.removeRigidBody(b.get());
  }
  void add(double mass, const btVector3& inertia, double z) {
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
    info.m_startWorldTransform.setOrigin(btVector3(0, 0, z));
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies.back().get(), 0, 0);  // collides with nothing
  }
  void run(int steps) {
    for (int k = 0; k < steps; ++k) {
      btRigidBody& body = *bodies[0];
      const btMatrix3x3& R = body.getWorldTransform().getBasis();
      for (const Push& p : pushes)
        body.applyForce(R * btVector3(p.force_B.x(), p.force_B.y(), p.force_B.z()),
                        R * btVector3(p.p_B.x(), p.p_B.y(), p.p_B.z()));
      world.stepSimulation(kStep, 0);
    }
  }
};

Contender make(const vehicle::Vehicle& v, int links) {
  auto world = std::make_shared<World>(v, links);
  return {"Bullet", [world](int n) { world->run(n); }, 1, {}};
}

}  // namespace
Contender bullet_free_body(const vehicle::Vehicle& v) { return make(v, 0); }
Contender bullet_chain(const vehicle::Vehicle& v) { return make(v, kLinks); }
}  // namespace omniflight::benchmarks

#else
namespace omniflight::benchmarks {
Contender bullet_free_body(const vehicle::Vehicle&) {
  return {"Bullet", {}, 1, "libbullet-dev is not installed"};
}
Contender bullet_chain(const vehicle::Vehicle& v) { return bullet_free_body(v); }
}  // namespace omniflight::benchmarks
#endif
