// The order of motors, from a made-up flight whose torques are known; and from a real one.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../src/motor_order.hpp"
#include "omniflight_recording/formats.hpp"

using namespace omniflight;
using namespace omniflight::cli;

namespace {

vehicle::Vehicle quadrotor() {
  vehicle::Vehicle v;
  v.mass = 1;
  v.inertia = Vec3(0.01, 0.012, 0.02).asDiagonal();
  const double x[] = {0.15, -0.15, 0.15, -0.15}, y[] = {-0.15, 0.15, 0.15, -0.15};
  for (int i = 0; i < 4; ++i) {
    vehicle::Rotor r;
    r.p_BR = Vec3(x[i], y[i], 0);
    r.spin = i < 2 ? -1 : 1;
    r.thrust_coefficient = 1.5e-5;
    r.drag_ratio = 0.02;
    r.max_thrust = 6;
    v.rotors.push_back(r);
  }
  return v;
}

/// Twenty seconds of small turns; motor k of the log is rotor order[k] of the vehicle.
recording::Recording flight(const vehicle::Vehicle& v, const std::vector<int>& order, double yaw_sign = 1) {
  recording::Recording r;
  auto &gyro = r.signals["gyro"], &speed = r.signals["rotor_speed"];
  gyro.name = "gyro";
  gyro.unit = speed.unit = "rad/s";
  speed.name = "rotor_speed";
  const int n = 10000;
  const double dt = 0.002;
  gyro.values.resize(n, 3);
  speed.values.resize(n, 4);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.02);
  const auto A = v.allocation_matrix(0);
  Vec3 w = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    const double t = dt * i;
    const Eigen::Vector4d wrench(9.81, 0.02 * std::sin(7 * t), 0.02 * std::sin(9.3 * t),
                                 0.004 * std::sin(4.1 * t));
    const Eigen::Vector4d thrust = A.bottomRows<4>().fullPivLu().solve(wrench);
    const Vec3 torque(wrench(1), wrench(2), yaw_sign * wrench(3));
    w += dt * (v.inertia.inverse() * (torque - w.cross(Vec3(v.inertia * w))));
    gyro.t_s.push_back(t);
    speed.t_s.push_back(t);
    for (int k = 0; k < 3; ++k) gyro.values(i, k) = w(k) + noise(random);
    for (int k = 0; k < 4; ++k)
      speed.values(i, k) = v.rotors[0].speed(thrust(order[static_cast<std::size_t>(k)]));
  }
  return r;
}

TEST(MotorOrder, TheRightOneIsConfirmed) {
  const auto v = quadrotor();
  const MotorOrder o = judge_motor_order(flight(v, {0, 1, 2, 3}), v);
  EXPECT_EQ(o.not_judged, "");
  EXPECT_GT(o.correlation.minCoeff(), 0.6);
  EXPECT_TRUE(o.better.empty());
  EXPECT_FALSE(o.spins_reversed);
  EXPECT_NE(to_text(o).find("their order fits the vehicle file"), std::string::npos);
}

TEST(MotorOrder, EveryOtherIsFoundAndProposed) {
  const auto v = quadrotor();
  std::vector<int> order{0, 1, 2, 3};
  while (std::next_permutation(order.begin(), order.end())) {
    const MotorOrder o = judge_motor_order(flight(v, order), v);
    ASSERT_EQ(o.better.size(), 4u) << to_text(o);
    for (int motor = 0; motor < 4; ++motor)  // rotor order[motor] is that motor
      EXPECT_EQ(o.better[static_cast<std::size_t>(order[static_cast<std::size_t>(motor)])], motor)
          << to_text(o);
  }
}

TEST(MotorOrder, ReversedSpinsAreTold) {
  const auto v = quadrotor();
  EXPECT_TRUE(judge_motor_order(flight(v, {0, 1, 2, 3}, -1), v).spins_reversed);
}

TEST(MotorOrder, WhatCannotBeToldIsSaid) {
  const auto v = quadrotor();
  auto r = flight(v, {0, 1, 2, 3});
  std::mt19937 random(6);
  std::normal_distribution<double> noise(0, 1);
  for (double& x : r.signals["gyro"].values.reshaped()) x = noise(random);
  const MotorOrder o = judge_motor_order(r, v);
  EXPECT_TRUE(o.better.empty()) << to_text(o);
  EXPECT_NE(to_text(o).find("cannot be told"), std::string::npos) << to_text(o);
  r.signals["rotor_speed"].values.conservativeResize(Eigen::NoChange, 3);
  EXPECT_EQ(judge_motor_order(r, v).not_judged, "the log has 3 motors, the vehicle file 4 rotors");
  EXPECT_EQ(judge_motor_order({}, v).not_judged, "no gyro was logged");
}

TEST(MotorOrder, OfARealFlightItFits) {
  const char* data = std::getenv("OMNIFLIGHT_REAL_DATA");
  const std::filesystem::path log =
      std::filesystem::path(data ? data : "") / "flights/crazyflie_brushless/eckart30";
  if (!data || !std::filesystem::exists(log)) GTEST_SKIP() << log << " is absent (OMNIFLIGHT_REAL_DATA)";
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto r = recording::load(log);
  ASSERT_TRUE(r) << r.error().text();
  const auto v = vehicle::load_vehicle("crazyflie_brushless");
  ASSERT_TRUE(v) << v.error().text();
  const MotorOrder o = judge_motor_order(*r, *v);
  EXPECT_GT(std::min(o.correlation.x(), o.correlation.y()), 0.5) << to_text(o);
  EXPECT_TRUE(o.better.empty());
  EXPECT_FALSE(o.spins_reversed);
}

}  // namespace
