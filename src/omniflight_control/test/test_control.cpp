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

// A step of 2 m with an actuator that gives 1 m/s^2: what the integrator gathers on the way it must lose
// again.
TEST(Controller, WindsUpLessWhenItIsToldWhatWasNotAchieved) {
  struct Flight {
    double overshoot = 0, peak_integral = 0, last_error = 0;
  };
  const auto fly = [](bool told) {
    ControllerConfig config;
    config.ki = Vec3::Constant(12);
    config.max_acceleration = 100;  // only the actuator saturates
    Controller controller(config);
    Reference r;
    r.p_WB.x() = 2;
    RigidState s;
    Vec6 unachieved = Vec6::Zero();
    Flight out;
    const double dt = 0.002;
    for (int k = 0; k < 15000; ++k) {
      const Vec6 demand = controller.update(r, s, dt, told ? unachieved : Vec6::Zero());
      const double given = std::clamp(demand[0], -1.0, 1.0);
      unachieved[0] = demand[0] - given;
      s.v_WB_W.x() += given * dt;
      s.p_WB.x() += s.v_WB_W.x() * dt;
      out.overshoot = std::max(out.overshoot, s.p_WB.x() - 2);
      out.peak_integral = std::max(out.peak_integral, std::abs(controller.integral_action()[0]));
      out.last_error = std::abs(s.p_WB.x() - 2);
    }
    return out;
  };
  const Flight told = fly(true), untold = fly(false);
  EXPECT_LT(told.overshoot, 0.5 * untold.overshoot);
  EXPECT_LT(told.peak_integral, 0.5 * untold.peak_integral);
  EXPECT_LT(told.last_error, 1e-3);
}

TEST(Controller, KeepsIntegratingOnAxesThatAreNotMissed) {
  Controller controller({});
  RigidState s;
  s.p_WB = Vec3(0, -0.1, -0.1);  // both axes ask for more
  Vec6 unachieved = Vec6::Zero();
  unachieved[2] = 1.0;
  for (int k = 0; k < 100; ++k) controller.update({}, s, 0.002, unachieved);
  EXPECT_GT(controller.integral_action()[1], 0.0);
  EXPECT_EQ(controller.integral_action()[2], 0.0);
  unachieved[2] = -1.0;  // too much was given: asking for more relieves
  for (int k = 0; k < 100; ++k) controller.update({}, s, 0.002, unachieved);
  EXPECT_GT(controller.integral_action()[2], 0.0);
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
