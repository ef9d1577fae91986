// Gains keep the margins that they are said to keep, and margins are those of closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_identification/pidn.hpp"

namespace omniflight::identification {
namespace {

constexpr LagPlant kMotor{2000, 0.034, 0.006};

TEST(Pidn, MarginsOfAnIntegralLoopAreThoseOfItsFormula) {
  // a lag that the integral gain alone closes, sampled fast: L = ki K / (s (tau s + 1))
  const LagPlant plant{1.0, 0.1, 0.0};
  const PidnGains gains{0, 5, 0, 0};
  const Margins m = margins(gains, plant, 1e-5);
  // |L| = 1 at w sqrt(1 + (w tau)^2) = 5
  const double w = std::sqrt((std::sqrt(1 + 4 * 25 * 0.01) - 1) / (2 * 0.01));
  EXPECT_NEAR(m.crossover_radps, w, 0.05 * w);
  EXPECT_NEAR(m.phase_margin_rad, 3.14159265 / 2 - std::atan(0.1 * w), 0.03);
  EXPECT_NEAR(m.delay_margin_s, m.phase_margin_rad / w, 0.05 * m.phase_margin_rad / w);
  EXPECT_TRUE(m.stable);
}

TEST(Pidn, TheSampledPlantIsTheContinuousOneAtLowFrequencies) {
  for (const double w : {1.0, 10.0, 30.0}) {
    const std::complex<double> exact = kMotor.gain / (1.0 + std::complex<double>(0, w * kMotor.lag_s)) *
                                       std::exp(std::complex<double>(0, -w * 0.0065));
    EXPECT_LT(std::abs(response(kMotor, 0.001, w) - exact), 0.002 * std::abs(exact)) << w;
  }
}

TEST(Pidn, TheGainsKeepTheSensitivityForEveryMotorOfTheSpread) {
  const TuningOptions options{.control_period_s = 0.002, .max_sensitivity = 1.6, .gain_spread = 0.25};
  const std::vector<LagPlant> plants{{2000, 0.030, 0.006}, {2000, 0.040, 0.006}};
  const auto tuning = tune_pidn(plants, options);
  ASSERT_TRUE(tuning) << tuning.error().text();
  for (const LagPlant& p : plants)
    for (const double factor : {0.75, 0.9, 1.0, 1.1, 1.25}) {
      LagPlant other = p;
      other.gain *= factor;
      const Margins m = margins(tuning->gains, other, options.control_period_s);
      EXPECT_TRUE(m.stable);
      EXPECT_LE(m.max_sensitivity, 1.6 + 1e-9);
    }
  EXPECT_LE(tuning->worst.max_sensitivity, 1.6 + 1e-9);
  EXPECT_GT(tuning->worst.max_sensitivity, 1.5);    // and it is used
  EXPECT_GE(tuning->worst.gain_margin, 1.6 / 0.6);  // Ms / (Ms - 1)
  EXPECT_GE(tuning->worst.phase_margin_rad, 2 * std::asin(1 / 3.2) - 0.05);
  EXPECT_LT(tuning->overshoot, 0.15);
  EXPECT_LT(tuning->rise_s, 2.2 * 0.035);  // faster than without a loop
}

TEST(Pidn, TheDelayMarginIsWhatTheLoopSurvives) {
  const auto tuning = tune_pidn({kMotor}, {.control_period_s = 0.001, .gain_spread = 0});
  ASSERT_TRUE(tuning) << tuning.error().text();
  LagPlant late = kMotor;
  late.delay_s += 0.9 * tuning->nominal.delay_margin_s;
  EXPECT_TRUE(margins(tuning->gains, late, 0.001).stable);
  late.delay_s = kMotor.delay_s + 1.2 * tuning->nominal.delay_margin_s;
  EXPECT_FALSE(margins(tuning->gains, late, 0.001).stable);
}

TEST(Pidn, ALongerControlPeriodMakesASlowerLoop) {
  const auto fast = tune_pidn({kMotor}, {.control_period_s = 0.001});
  const auto slow = tune_pidn({kMotor}, {.control_period_s = 0.02});
  ASSERT_TRUE(fast && slow);
  EXPECT_LT(slow->gains.kp, fast->gains.kp);
  EXPECT_GT(slow->closed_loop_s, fast->closed_loop_s);
}

TEST(Pidn, RefusesWhatIsNoMotor) {
  EXPECT_FALSE(tune_pidn({}));
  EXPECT_FALSE(tune_pidn({{-1, 0.03, 0}}));
  EXPECT_FALSE(tune_pidn({{1, std::nan(""), 0}}));
  const auto slow = tune_pidn({{1, 0.005, 0}}, {.control_period_s = 0.05});
  ASSERT_FALSE(slow);
  EXPECT_NE(slow.error().text().find("control period"), std::string::npos);
}

}  // namespace
}  // namespace omniflight::identification
