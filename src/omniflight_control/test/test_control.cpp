#include <gtest/gtest.h>

#include "omniflight_control/controller.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::control {
namespace {

TEST(Controller, AsksForTheReferenceAccelerationWhenThereIsNoError) {
  Controller controller({});
  Reference r;
  r.q_WB = exp_rotation(Vec3(0.3, -0.2, 1.0));
  r.w_WB_B = Vec3(0.1, 0.2, -0.3);
  r.a_WB_W = Vec3(1, 2, 3);
  r.dw_WB_B = Vec3(-1, 0.5, 2);
  const RigidState s{r.p_WB, r.q_WB, r.v_WB_W, r.w_WB_B};
  Vec6 want;
  want << r.a_WB_W, r.dw_WB_B;
  EXPECT_LT((controller.update(r, s, 0.002) - want).norm(), 1e-12);
}

TEST(Controller, RestoresAttitudeFromAnyDirection) {
  Random rng(1);
  for (int i = 0; i < 50; ++i) {
    const Quat q = exp_rotation(Vec3(rng.normal(), rng.normal(), rng.normal()));
    const Vec3 phi = 0.5 * Vec3(rng.normal(), rng.normal(), rng.normal());
    const Vec3 e = attitude_error(q, q * exp_rotation(phi));
    EXPECT_GT(e.dot(phi), 0.0);
    EXPECT_LT((attitude_error(q, q * exp_rotation(1e-4 * phi)) - 1e-4 * phi).norm(), 1e-9);
  }
}

TEST(Controller, IntegralActionRemovesASteadyLoadAndDoesNotWindUp) {
  // double integrator with a constant load, as an unknown payload makes it
  Controller controller({});
  RigidState s;
  const Reference r;
  const double load = -2.0, dt = 0.002;
  for (int k = 0; k < 40000; ++k) {
    const Vec6 u = controller.update(r, s, dt);
    s.v_WB_W.z() += (u[2] + load) * dt;
    s.p_WB.z() += s.v_WB_W.z() * dt;
  }
  EXPECT_NEAR(s.p_WB.z(), 0.0, 1e-4);
  EXPECT_NEAR(controller.integral_action()[2], 2.0, 1e-3);

  Controller blocked({});
  RigidState far;
  far.p_WB.z() = -100;
  for (int k = 0; k < 10000; ++k) blocked.update(r, far, dt);
  EXPECT_EQ(blocked.integral_action().norm(), 0.0) << "the integrator moved while the feedback was saturated";
}

TEST(Estimator, FollowsAMovingBodyWithDelayedMotionCapture) {
  // p = (sin t, 0, 1), yaw = 0.5 sin(2t); mocap 20 ms late at 100 Hz, IMU 1 kHz
  Estimator estimator({});
  const auto pose = [](double t) {
    return std::pair{Vec3(std::sin(t), 0, 1), exp_rotation(Vec3(0, 0, 0.5 * std::sin(2 * t)))};
  };
  double worst_p = 0, worst_v = 0, worst_R = 0;
  for (int k = 0; k < 8000; ++k) {
    const double t = 1e-3 * k;
    const auto [p, q] = pose(t);
    const Vec3 a(-std::sin(t), 0, 0);
    estimator.add_imu(t, q.conjugate() * (a + Vec3(0, 0, kGravity)), Vec3(0, 0, std::cos(2 * t) + 0.02));
    if (k % 10 == 0 && k >= 20) {
      const auto [pm, qm] = pose(t - 0.02);
      estimator.add_mocap(t - 0.02, pm, qm);
    }
    if (t < 4.0) continue;
    worst_p = std::max(worst_p, (estimator.state().p_WB - p).norm());
    worst_v = std::max(worst_v, (estimator.state().v_WB_W - Vec3(std::cos(t), 0, 0)).norm());
    worst_R = std::max(worst_R, estimator.state().q_WB.angularDistance(q));
  }
  EXPECT_LT(worst_p, 1e-3);
  EXPECT_LT(worst_v, 1e-2);
  EXPECT_LT(worst_R, 2e-3);
  EXPECT_NEAR(estimator.gyro_bias().z(), 0.02, 0.005);
}

TEST(Estimator, IgnoresWhatIsNotANumber) {
  Estimator estimator({});
  estimator.add_mocap(0.0, Vec3(1, 2, 3), Quat::Identity());
  estimator.add_imu(0.001, Vec3(std::nan(""), 0, 0), Vec3::Zero());
  estimator.add_mocap(0.002, Vec3(0, 0, INFINITY), Quat::Identity());
  EXPECT_EQ(estimator.refused(), 2u);
  EXPECT_TRUE(is_finite(estimator.state()));
}

}  // namespace
}  // namespace omniflight::control
