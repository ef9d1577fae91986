// What the controller's guard makes of ticks, poses and estimate.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace omniflight::components
