// What the controller's guard makes of ticks, poses and estimate.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "../src/flight_guard.hpp"
#include "omniflight_control/estimator.hpp"

namespace omniflight::components {
namespace {

using safety::Action;

constexpr double kPeriod = 0.002;  // s

/// A hovering vehicle whose estimator hears a true IMU and true poses.
struct Hover {
  FlightGuard guard{GuardConfig{}};
  control::Estimator estimator{control::EstimatorConfig{}};
  double t = 10.0;

  void step(bool told = true, const Vec3& pose = Vec3(0, 0, 1.3), const Vec3& force = Vec3(0, 0, kGravity)) {
    t += kPeriod;
    estimator.add_imu(t, force, Vec3::Zero());
    const Vec3 p = pose + Vec3(0, 0, 1e-9 * t);  // no two are equal to the bit
    if (guard.believes(t, p, Quat::Identity(), t, true, estimator))
      estimator.add_mocap(guard.poses().believed_s(), p, Quat::Identity());
    if (!told) return;
    guard.tick(t, kPeriod);
    guard.update(t, estimator, safety::Wish::none);
  }
  void run(double seconds) {
    for (const double end = t + seconds; t < end;) step();
  }
};

TEST(FlightGuard, HoldsWhileControlPeriodsAreMissedAndFliesOn) {
  Hover h;
  h.run(2);
  EXPECT_EQ(h.guard.action(), Action::fly);
  const double begun = h.t;
  while (h.guard.action() == Action::fly && h.t < begun + 5)
    for (int k = 0; k < 10; ++k) h.step(k != 9);  // every tenth
  EXPECT_EQ(h.guard.words(), "hold: periods_missed");
  EXPECT_NEAR(h.t - begun, 1.5, 0.06) << "0.5 s until 5 % of a second are missed, then the rung's 1 s";
  h.run(6);
  EXPECT_EQ(h.guard.action(), Action::fly);
}

TEST(FlightGuard, FivePercentAreFlownWith) {
  Hover h;
  h.run(1);
  for (int k = 0; k < 5000; ++k) h.step(k % 25 != 24);
  EXPECT_EQ(h.guard.action(), Action::fly);
}

TEST(FlightGuard, AnEstimateThatLeavesThePosesEndsInTheRamp) {
  Hover h;
  h.run(2);
  const double begun = h.t;
  // an accelerometer that broke: 400 m/s2 aside, faster than poses correct
  while (h.guard.action() == Action::fly && h.t < begun + 2)
    h.step(true, Vec3(0, 0, 1.3), Vec3(400, 0, kGravity));
  EXPECT_EQ(h.guard.words(), "ramp_down: estimate_diverged");
  EXPECT_LT(h.t - begun, 0.4) << "0.2 s from 0.5 m apart";
}

TEST(FlightGuard, PosesThatLeapDescendOnTheImu) {
  Hover h;
  h.run(2);
  const double begun = h.t;
  while (h.guard.action() == Action::fly && h.t < begun + 2) h.step(true, Vec3(2, 0, 1.3));
  EXPECT_EQ(h.guard.words(), "descend: pose_lost");
  EXPECT_NEAR(h.t - begun, 0.5, 0.01);
}

/// A hover at 1.3 m beside a table of 0.8 m (its voxels' tops), which begins at x = 0.5 m; the vehicle's one
/// shape is a ball of 0.1 m.
struct OverTable : Hover {
  static MapBelow below() {
    octomap::OcTree tree(0.1);
    for (int x = -10; x < 20; ++x)
      for (int y = -10; y < 10; ++y)
        for (int z = 0; z < 15; ++z)
          tree.updateNode(0.05 + 0.1 * x, 0.05 + 0.1 * y, 0.05 + 0.1 * z, x >= 5 && z == 7);
    vehicle::Vehicle vehicle;
    vehicle.collision.push_back(
        {vehicle::CollisionShape::Kind::sphere, Vec3::Zero(), Quat::Identity(), Vec3(0.1, 0, 0)});
    return {planning::SurfaceBelow::create(tree).value(), vehicle};
  }
  OverTable() { guard = FlightGuard(GuardConfig{}, below()); }

  /// Lands by the operator's wish; the vehicle is where the reference is, pushed aside at `drift` [m/s].
  /// Height [m] at which the descent ends.
  double land(double drift = 0.0) {
    run(2);
    const Trajectory plan = Trajectory::create({{0.0, still()}, {1.0, still()}}).value();
    for (const double end = t + 20; t < end && guard.action() != Action::ramp_down;) {
      t += kPeriod;
      at.x() += drift * kPeriod;
      estimator = control::Estimator(control::EstimatorConfig{});  // knows where it is
      estimator.add_imu(t, Vec3(0, 0, kGravity), Vec3::Zero());
      estimator.add_mocap(t, at, Quat::Identity());
      guard.tick(t, kPeriod);
      guard.update(t, estimator, safety::Wish::land);
      at.z() = guard.reference(plan, 0.0, t, estimator.state()).p_WB.z();
    }
    return at.z();
  }
  Reference still() const {
    Reference r;
    r.p_WB = at;
    return r;
  }
  Vec3 at{0, 0, 1.3};
};

TEST(FlightGuard, ADescentEndsOnTheTable) {
  OverTable h;
  h.at.x() = 1.0;
  EXPECT_NEAR(h.land(), 0.8 + 0.1 + 0.05, 0.002);
  EXPECT_EQ(h.guard.words(), "ramp_down: operator_land");
  EXPECT_EQ(h.guard.landing_words(), "ends on what the map has at 0.80 m, the body origin at 0.90 m");
}

TEST(FlightGuard, ADescentBesideTheTableEndsAtTheGround) {
  OverTable h;
  EXPECT_NEAR(h.land(), 0.1, 0.002);
  EXPECT_EQ(h.guard.landing_words(), "ends at the ground of the test bed, 0.00 m");
}

TEST(FlightGuard, ADescentThatDriftsOverTheTableEndsOnIt) {
  OverTable h;
  h.at.x() = 0.3;
  EXPECT_NEAR(h.land(0.2), 0.95, 0.002) << "over it after 0.5 s, 0.15 m down";
}

}  // namespace
}  // namespace omniflight::components
