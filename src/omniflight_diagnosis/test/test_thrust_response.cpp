// Thrust that follows or leads the speeds of the rotors.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../src/conditioning/thrust_response.hpp"
#include "../src/conditioning/torque_alignment.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kRate = 500;  // Hz

/// Rotor speeds [rad/s] that jitter about hover, 10 s.
Eigen::MatrixXd jitter(const vehicle::Vehicle& v) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd x(5000, v.rotor_count());
  for (double& value : x.reshaped()) value = normal(random);
  x = low_pass(x, kRate, 20);
  for (Eigen::Index r = 0; r < x.cols(); ++r) {
    const double hover = 0.6 * v.rotors[static_cast<std::size_t>(r)].max_speed();
    x.col(r) = (hover + 0.3 * hover * x.col(r).array()).matrix();
  }
  return x;
}

std::optional<ThrustResponse> response_of(const Eigen::MatrixXd& real, double delay_s = 0) {
  const vehicle::Vehicle v = test::omnimorph();
  const Eigen::MatrixXd speed = jitter(v), alpha = Eigen::MatrixXd::Constant(speed.rows(), 1, 0.5);
  const std::vector<char> use(static_cast<std::size_t>(speed.rows()), 1);
  Eigen::MatrixXd dw = rotor_excitation(real, real, alpha, kRate, v).torque * v.inertia.inverse();
  if (delay_s != 0) dw = delayed(dw, delay_s, kRate);
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal(0, 0.1 * dw.norm() / std::sqrt(dw.size()));
  for (double& value : dw.reshaped()) value += normal(random);
  const RotorExcitation rotors = rotor_excitation(speed, speed, alpha, kRate, v);
  return thrust_response(RotorRegression(dw, Eigen::MatrixXd(0, 3), rotors, kRate, use), 0.0015);
}

TEST(ThrustResponse, ThrustThatComesLateIsTold) {
  const Eigen::MatrixXd speed = jitter(test::omnimorph());
  const auto found = response_of(responding(speed, {.time = 0.02, .lead = -1}, kRate));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->lead, -1);
  EXPECT_NEAR(found->time, 0.02, 0.003);  // a sample of 2 ms is left to the clock
  EXPECT_GT(found->log_factor, 20);
}

TEST(ThrustResponse, ThrustThatOvershootsIsTold) {
  const Eigen::MatrixXd speed = jitter(test::omnimorph());
  const auto found = response_of(responding(speed, {.time = 0.015, .lead = 0.4}, kRate));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->lead, 0.4);
  EXPECT_NEAR(found->time, 0.015, 0.003);
}

TEST(ThrustResponse, RotorsThatAnswerToTheMotionTellNothing) {
  const Eigen::MatrixXd speed = jitter(test::omnimorph());
  EXPECT_TRUE(response_of(responding(speed, {.time = 0.015, .lead = 0.4}, kRate)));
  EXPECT_FALSE(response_of(responding(speed, {.time = 0.015, .lead = 0.4}, kRate), -0.012));
}

TEST(ThrustResponse, AClockThatIsOffAndThrustAtOnceAreNot) {
  const Eigen::MatrixXd speed = jitter(test::omnimorph());
  EXPECT_FALSE(response_of(speed));
  EXPECT_FALSE(response_of(speed, 0.009));
}

}  // namespace
}  // namespace omniflight::diagnosis
