// Flips, crashes and what is neither.
#include "../src/conditioning/ground.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace omniflight::diagnosis {
namespace {

/// Seconds that are called crashed of a quadrotor that turns over about y at 5 s, one turn a second: once
/// round, or to its back.
double crashed_s(bool recovers, bool carried_after) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto v = vehicle::load_vehicle("crazyflie_brushless");
  EXPECT_TRUE(v);
  constexpr double kRate = 100;
  constexpr Eigen::Index n = 1200;
  const double hover = v->rotors[0].speed(v->mass * kGravity / 4);
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(n, 3), speed = Eigen::MatrixXd::Constant(n, 4, hover),
                  force = Eigen::MatrixXd::Zero(n, 3), q = Eigen::MatrixXd::Zero(n, 4);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / kRate;
    const double angle = 2 * kPi * std::clamp(t - 5, 0.0, recovers ? 1.0 : 0.5);
    p.row(i) << 0.3 * std::sin(t), 0.2 * std::cos(2 * t), 1 + 0.1 * std::sin(3 * t);
    q.row(i) << std::cos(angle / 2), 0, std::sin(angle / 2), 0;
    force(i, 2) = kGravity;
    if (t > 5.5 && !carried_after) speed.row(i).setConstant(0.2 * hover);
  }
  const Ground g = find_ground(p, true, speed, force, q, kRate, *v, {});
  return static_cast<double>(std::count(g.crashed.begin(), g.crashed.end(), 1)) / kRate;
}

TEST(Ground, AFlipIsNoCrash) { EXPECT_EQ(crashed_s(true, true), 0); }

TEST(Ground, WhoeverStaysOnItsBackOrIsNoLongerCarriedHasCrashed) {
  EXPECT_NEAR(crashed_s(false, true), 6.7, 0.2);
  EXPECT_NEAR(crashed_s(true, false), 6.7, 0.2);
}

}  // namespace
}  // namespace omniflight::diagnosis
