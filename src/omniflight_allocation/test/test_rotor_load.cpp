#include "omniflight_allocation/rotor_load.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "omniflight_core/random.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

TEST(RotorLoad, ForceHullAtZeroTorqueHasTheClosedForm) {
  const auto v = omnimorph();
  const double f = 6.25;
  for (const double alpha : {0.35, 0.6, 0.9}) {
    const RotorLoad limits = RotorLoad::create(v, alpha).value();
    EXPECT_EQ(limits.rank(), 6);
    const double s = std::sin(alpha), c = std::cos(alpha);
    const Vec3 vertices[] = {
        {4 * s * f, 4 * s * f, 0}, {0, 0, 8 * c * f}, {4 * s * f, 0, 4 * c * f}, {0, 4 * s * f, 4 * c * f}};
    for (const Vec3& force : vertices) {
      Vec6 w = Vec6::Zero();
      w.head<3>() = force;
      EXPECT_NEAR(limits.load(w), 1.0, 1e-9) << alpha << ": " << force.transpose();
    }
  }
}

TEST(RotorLoad, LoadIsTheLeastLargestThrust) {
  // The load of A u never exceeds max |u| / f, and random allocations of the same wrench never beat it.
  const auto v = omnimorph();
  const RotorLoad limits = RotorLoad::create(v, 0.7).value();
  const Eigen::MatrixXd a = v.allocation_matrix(0.7);
  const Eigen::MatrixXd kernel = Eigen::FullPivLU<Eigen::MatrixXd>(a).kernel();
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXd u(8);
    for (int k = 0; k < 8; ++k) u[k] = random.uniform(-6.25, 6.25);
    const double load = limits.load(a * u);
    double best = 1e9;  // dense search over the two free directions
    for (int j = 0; j < 4000; ++j) {
      const Eigen::VectorXd z = Eigen::Vector2d(random.uniform(-12, 12), random.uniform(-12, 12));
      best = std::min(best, (u + kernel * z).cwiseAbs().maxCoeff() / 6.25);
    }
    best = std::min(best, u.cwiseAbs().maxCoeff() / 6.25);
    EXPECT_LE(load, best + 1e-9);
    EXPECT_GT(load, best - 0.25);
  }
}

TEST(RotorLoad, IsTheLargestOverTheNormalsOfEveryFiveRotors) {
  // each by a decomposition of its own, dependent rotors included: at 0.35 rad and 0.9 rad some faces have
  // six
  const auto v = omnimorph();
  Random random(9);
  for (const double alpha : {0.05, 0.35, 0.7, 0.9, 1.5}) {
    const RotorLoad limits = RotorLoad::create(v, alpha).value();
    ASSERT_EQ(limits.rank(), 6);
    const Eigen::MatrixXd a = v.allocation_matrix(alpha);
    std::vector<Vec6> normals;
    for (unsigned chosen = 0; chosen < 256; ++chosen) {
      if (std::popcount(chosen) != 5) continue;
      Eigen::Matrix<double, 5, 6> five;
      for (int k = 0, row = 0; k < 8; ++k)
        if (chosen >> k & 1) five.row(row++) = a.col(k).transpose();
      const Eigen::FullPivLU<Eigen::MatrixXd> lu(five);
      if (lu.dimensionOfKernel() == 1) normals.emplace_back(lu.kernel().col(0));
    }
    ASSERT_GE(normals.size(), 20u);
    for (int i = 0; i < 200; ++i) {
      Eigen::VectorXd u(8);
      for (int k = 0; k < 8; ++k) u[k] = random.uniform(-6.25, 6.25);
      const Vec6 wrench = a * u;
      double most = 0.0;
      for (const Vec6& n : normals)
        most = std::max(most, std::abs(n.dot(wrench)) / (6.25 * (n.transpose() * a).cwiseAbs().sum()));
      EXPECT_NEAR(limits.load(wrench), most, 1e-9) << alpha;
    }
  }
}

TEST(RotorLoad, OmnidirectionalFromTheTiltOfTheThesis) {
  const auto v = omnimorph(1.595, 5.95);
  Random random(5);
  const auto worst = [&](double alpha_deg) {
    const RotorLoad limits = RotorLoad::create(v, to_radians(alpha_deg)).value();
    double load = 0.0;
    for (int i = 0; i < 20000; ++i)
      load = std::max(load,
                      limits.hover_load(exp_rotation(Vec3(random.uniform(-3, 3), random.uniform(-3, 3), 0))));
    return load;
  };
  EXPECT_GT(worst(40.5), 1.0);
  EXPECT_LT(worst(41.5), 1.0);
}

TEST(RotorLoad, HoveringChangesNoFasterThanItsSlope) {
  auto v = omnimorph(1.595, 5.95);
  v.center_of_mass = Vec3(0.01, -0.02, 0.005);
  const RotorLoad limits = RotorLoad::create(v, to_radians(45)).value();
  Random random(8);
  double steepest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    Reference a, b;
    a.q_WB = exp_rotation(Vec3(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)));
    const Vec3 turn = 0.05 * Vec3(random.normal(), random.normal(), random.normal());
    b.q_WB = a.q_WB * exp_rotation(turn);
    const double load = limits.hover_load(a.q_WB), change = std::abs(load - limits.hover_load(b.q_WB));
    EXPECT_NEAR(load, limits.motion_load(a), 1e-9);
    EXPECT_LE(change, limits.hover_slope() * turn.norm() + 1e-9);
    steepest = std::max(steepest, change / turn.norm());
  }
  EXPECT_GT(steepest, 0.5 * limits.hover_slope()) << "no bound that tells nothing";
}

TEST(RotorLoad, AQuadrotorHoversUprightOnly) {
  vehicle::Vehicle v;
  v.mass = 0.03;
  v.inertia = Mat3::Identity() * 1e-5;
  for (int i = 0; i < 4; ++i) {
    vehicle::Rotor r;
    r.p_BR = Vec3(i < 2 ? 0.03 : -0.03, i % 2 ? 0.03 : -0.03, 0);
    r.spin = (i == 0 || i == 3) ? 1 : -1;
    r.drag_ratio = 0.006;
    r.thrust_coefficient = 1e-8;
    r.max_thrust = 0.15;
    v.rotors.push_back(r);
  }
  const RotorLoad limits = RotorLoad::create(v, 0.0).value();
  EXPECT_EQ(limits.rank(), 4);
  EXPECT_NEAR(limits.hover_load(Quat::Identity()), std::abs(0.03 * kGravity / 4 - 0.075) / 0.075, 1e-9);
  EXPECT_TRUE(std::isinf(limits.hover_load(exp_rotation(Vec3(0.05, 0, 0)))));
  EXPECT_TRUE(std::isinf(limits.hover_slope()));
}

}  // namespace
}  // namespace omniflight::allocation
