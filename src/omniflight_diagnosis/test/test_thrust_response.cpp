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

std::optional<ThrustResponse> response_of(const Eigen::MatrixXd& real, double delay_s = 0) {
  const vehicle::Vehicle v = test::omnimorph();
  const Eigen::MatrixXd speed = test::jittering_speeds(v, kRate),
                        alpha = Eigen::MatrixXd::Constant(speed.rows(), 1, 0.5);
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
  const Eigen::MatrixXd speed = test::jittering_speeds(test::omnimorph(), kRate);
  const auto found = response_of(responding(speed, {.time = 0.02, .lead = -1}, kRate));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->lead, -1);
  EXPECT_NEAR(found->time, 0.02, 0.003);  // a sample of 2 ms is left to the clock
  EXPECT_GT(found->log_factor, 20);
}

TEST(ThrustResponse, ThrustThatOvershootsIsTold) {
  const Eigen::MatrixXd speed = test::jittering_speeds(test::omnimorph(), kRate);
  const auto found = response_of(responding(speed, {.time = 0.015, .lead = 0.4}, kRate));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->lead, 0.4);
  EXPECT_NEAR(found->time, 0.015, 0.003);
}

TEST(ThrustResponse, RotorsThatAnswerToTheMotionTellNothing) {
  const Eigen::MatrixXd speed = test::jittering_speeds(test::omnimorph(), kRate);
  EXPECT_TRUE(response_of(responding(speed, {.time = 0.015, .lead = 0.4}, kRate)));
  EXPECT_FALSE(response_of(responding(speed, {.time = 0.015, .lead = 0.4}, kRate), -0.012));
}

TEST(ThrustResponse, AClockThatIsOffAndThrustAtOnceAreNot) {
  const Eigen::MatrixXd speed = test::jittering_speeds(test::omnimorph(), kRate);
  EXPECT_FALSE(response_of(speed));
  EXPECT_FALSE(response_of(speed, 0.009));
}

}  // namespace
}  // namespace omniflight::diagnosis
