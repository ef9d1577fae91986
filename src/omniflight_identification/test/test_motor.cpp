// Lag, delay and gain of simulated motors (synthetic), and the signals that excite them.
#include <gtest/gtest.h>

#include "known_systems.hpp"
#include "omniflight_identification/motor_dynamics.hpp"
#include "omniflight_identification/prbs.hpp"
#include "omniflight_identification/residual_tests.hpp"
#include "omniflight_identification/selection.hpp"

namespace omniflight::identification {
namespace {

constexpr double kPeriod = 0.002, kGain = 2000, kVoltageGain = 150;

/// A motor that is integrated in steps of a twentieth of a sample: command (bits of 0.05 s), battery voltage
/// that sags, speed with white noise.
Experiment motor_run(double lag_up, double lag_down, double delay, double noise, Eigen::Index samples,
                     Random& random) {
  constexpr int kSub = 20;
  const Eigen::VectorXd bits = testing::random_binary(samples, 25, random);
  Experiment e{Eigen::VectorXd(samples), Eigen::MatrixXd(samples, 2)};
  double y = 900, sag = 0;
  for (Eigen::Index t = 0; t < samples; ++t) {
    e.u(t, 0) = 0.5 + 0.1 * bits[t];
    sag += 0.01 * random.normal();
    e.u(t, 1) = 3.9 - 0.0001 * static_cast<double>(t) + 0.1 * std::sin(sag);
  }
  for (Eigen::Index t = 0; t < samples; ++t) {
    e.y[t] = y + noise * random.normal();
    for (int k = 0; k < kSub; ++k) {
      const double now = (static_cast<double>(t) + (k + 0.5) / kSub) * kPeriod - delay;
      const auto at = std::max<Eigen::Index>(0, static_cast<Eigen::Index>(std::floor(now / kPeriod)));
      const double target = kGain * (e.u(at, 0) - 0.5) + kVoltageGain * (e.u(t, 1) - 3.9) + 1000;
      y = target + std::exp(-kPeriod / kSub / (target > y ? lag_up : lag_down)) * (y - target);
    }
  }
  return e;
}

TEST(Motor, LagsUpAndDownDelayAndGainsAreFoundWithinThreeSigma) {
  int within = 0;
  constexpr int kMotors = 100;
  for (int k = 0; k < kMotors; ++k) {
    Random random(static_cast<std::uint64_t>(k) + 1, "motor");
    const double up = random.uniform(0.02, 0.05), down = random.uniform(0.04, 0.09),
                 delay = 1e-4 * std::floor(random.uniform(20, 120));
    const Dataset data{
        kPeriod, {motor_run(up, down, delay, 8, 2500, random), motor_run(up, down, delay, 8, 2500, random)}};
    const auto motor = fit_dynamics(data);
    ASSERT_TRUE(motor) << motor.error().text();
    EXPECT_NEAR(motor->lag_up, up, 0.001);
    EXPECT_NEAR(motor->lag_down, down, 0.0015);
    EXPECT_NEAR(motor->delay, delay, 0.0005);
    EXPECT_NEAR(motor->gain[0], kGain, 0.01 * kGain);
    EXPECT_NEAR(motor->gain[1], kVoltageGain, 0.05 * kVoltageGain);
    within += std::abs(motor->lag_up - up) < 3 * motor->sigma_lag_up() &&
              std::abs(motor->lag_down - down) < 3 * motor->sigma_lag_down() &&
              std::abs(motor->delay - delay) < 3 * motor->sigma_delay();
    EXPECT_GT(motor->fit_percent, 85);
  }
  EXPECT_GE(within, 95);
}

TEST(Motor, TheDelayOfAFirstOrderModelIsThatOfTheMotor) {
  Random random(3);
  const Dataset data = detrended({kPeriod, {motor_run(0.03, 0.03, 0.008, 8, 4000, random)}}, Trend::line);
  const auto delay = estimate_delay(data, 12);
  ASSERT_TRUE(delay) << delay.error().text();
  // four samples on the way and one that every sampled lag has
  EXPECT_EQ(delay->samples, 5);
  EXPECT_GT(delay->loss[0], 1.2 * delay->loss[4]);
}

TEST(Motor, AMotorThatHearsAnotherCommandIsRefused) {
  Random random(4);
  Dataset data{kPeriod, {motor_run(0.03, 0.03, 0.006, 8, 3000, random)}};
  data.experiments[0].u.col(0) = data.experiments[0].u.col(0).reverse().eval();
  const auto motor = fit_dynamics(data);
  if (motor) {
    EXPECT_LT(motor->fit_percent, 20) << "lag " << motor->lag() << " s";
  } else {
    EXPECT_FALSE(motor.error().next_step.empty());
  }
}

TEST(Motor, ResponseFallsByThreeDecibelsAtTheLagsCorner) {
  MotorDynamics m;
  m.gain = Eigen::VectorXd::Constant(1, 10);
  m.lag_up = m.lag_down = 0.05;
  m.delay = 0.01;
  EXPECT_NEAR(std::abs(response(m, 20)), 10 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(std::arg(response(m, 20)), -0.25 * 3.14159265358979 - 0.2, 1e-9);
}

TEST(Prbs, IsWhiteWithinItsLevelsAndItsBand) {
  const auto prbs = make_prbs({.low = 0.4, .high = 0.6, .band_hz = 8, .period_s = 0.002, .duration_s = 20});
  ASSERT_TRUE(prbs) << prbs.error().text();
  EXPECT_GE(prbs->values.minCoeff(), 0.4);
  EXPECT_LE(prbs->values.maxCoeff(), 0.6);
  EXPECT_NEAR(prbs->bit_s, 0.443 / 8, 0.002);
  const auto white = white_part(prbs->values);
  ASSERT_TRUE(white);
  EXPECT_NEAR(white->bit_samples, prbs->bit_samples, 0.05);
  // the lead at the mean of the levels, 1000 samples, is not part of it
  EXPECT_GE(white->from, 1000);
  EXPECT_LE(white->to, prbs->values.size() - 1000);
  EXPECT_GT(white->to - white->from, 9000);
}

TEST(Prbs, MaximalLengthSequencesRepeatOnlyAfterTheirLength) {
  const auto prbs = make_prbs(
      {.low = -1, .high = 1, .band_hz = 22, .period_s = 0.01, .duration_s = 0.02 * 511 - 0.001, .lead_s = 0});
  ASSERT_TRUE(prbs) << prbs.error().text();
  ASSERT_EQ(prbs->register_bits, 9);
  // 510 of the 511 bits: as many of one level as of the other, but for one
  double sum = 0;
  for (Eigen::Index k = 0; k < prbs->values.size(); k += prbs->bit_samples) sum += prbs->values[k];
  EXPECT_LE(std::abs(sum), 2);
}

TEST(Prbs, ItsSlopeIsLimited) {
  const auto prbs = make_prbs(
      {.low = 100, .high = 200, .band_hz = 4, .period_s = 0.002, .duration_s = 10, .max_slope = 5000});
  ASSERT_TRUE(prbs) << prbs.error().text();
  const Eigen::VectorXd steps =
      prbs->values.tail(prbs->values.size() - 1) - prbs->values.head(prbs->values.size() - 1);
  EXPECT_LE(steps.cwiseAbs().maxCoeff(), 5000 * 0.002 + 1e-9);
  EXPECT_TRUE(white_part(prbs->values));
}

TEST(Prbs, WhatIsNoPrbsHasNoWhitePart) {
  Eigen::VectorXd sine(4000), square(4000);
  for (Eigen::Index t = 0; t < 4000; ++t) {
    sine[t] = std::sin(0.02 * static_cast<double>(t));
    square[t] = t / 50 % 2 == 0 ? 1 : 0;
  }
  EXPECT_FALSE(white_part(sine));
  EXPECT_FALSE(white_part(square));
  EXPECT_FALSE(white_part(Eigen::VectorXd::Ones(4000)));
}

TEST(Prbs, RefusesWhatItCannotMakeAndSaysWhy) {
  const auto refused = [](const PrbsConfig& config, const char* word) {
    const auto prbs = make_prbs(config);
    ASSERT_FALSE(prbs);
    EXPECT_NE(prbs.error().text().find(word), std::string::npos) << prbs.error().text();
  };
  refused({.low = 1, .high = 1}, "levels");
  refused({.low = 0, .high = 1, .band_hz = 40, .period_s = 0.01}, "band");
  refused({.low = 0, .high = 100, .band_hz = 20, .period_s = 0.002, .max_slope = 100}, "slope");
  refused({.low = 0, .high = 1, .seed = 0}, "seed");
  refused({.low = 0, .high = 1, .duration_s = 1e9}, "duration");
  refused({.low = 0, .high = std::nan("")}, "finite");
}

TEST(Prbs, BeyondTheMotorsBandNothingFollows) {
  EXPECT_LT(followed_share(0.004, 0.07), 0.1);
  EXPECT_GT(followed_share(0.05, 0.034), 0.7);
}

TEST(Residuals, ChiSquaredTailIsThatOfTables) {
  EXPECT_NEAR(chi_squared_tail(37.652, 25), 0.05, 0.002);
  EXPECT_NEAR(chi_squared_tail(44.314, 25), 0.01, 0.001);
  EXPECT_NEAR(chi_squared_tail(24.337, 25), 0.5, 0.002);
  EXPECT_NEAR(chi_squared_tail(6.635, 1), 0.01, 0.002);
}

}  // namespace
}  // namespace omniflight::identification
