// The loop of flying, scoring and choosing the next gains (synthetic motors).
#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_identification/gain_search.hpp"
#include "omniflight_identification/prbs.hpp"
#include "omniflight_identification/speed_loop.hpp"

namespace omniflight::identification {
namespace {

const SpeedLoop kLoop{{2000, 0.034, 0.006}, {2000, 0.050, 0.006}, 0.002, 2.0, 1.0, 1};

Eigen::VectorXd set_point() {
  return make_prbs(
             {.low = 900, .high = 1000, .band_hz = 3, .period_s = 0.002, .duration_s = 8, .lead_s = 0.5})
      ->values;
}

TEST(SpeedLoop, IsTheClosedLoopOfTheSampledPlant) {
  SpeedLoop loop = kLoop;
  loop.down = loop.up;
  loop.noise_radps = 0;
  loop.command_max = 0;
  const PidnGains gains{8e-4, 0.02, 2e-6, 200};
  Eigen::VectorXd step = Eigen::VectorXd::Ones(200);
  step[0] = 0;
  const Eigen::VectorXd y = simulated(loop, gains, step);
  const std::vector<double> expected = closed_loop_step(gains, loop.up, loop.control_period_s, 199);
  for (Eigen::Index t = 1; t < 200; ++t)
    EXPECT_NEAR(y[t], expected[static_cast<std::size_t>(t - 1)], 1e-9) << t;
}

TEST(SpeedLoop, LimitsOfTheCommandLimitTheSpeedAndDoNotWindUp) {
  SpeedLoop loop = kLoop;
  loop.noise_radps = 0;
  Eigen::VectorXd wanted = Eigen::VectorXd::Constant(2000, 2600);  // beyond 2000 rad/s of full command
  wanted.head(100).setConstant(1000);
  wanted.tail(500).setConstant(1000);
  const Eigen::VectorXd y = simulated(loop, {5e-4, 0.01, 0, 0}, wanted);
  EXPECT_LE(y.maxCoeff(), 2000 + 1e-9);
  EXPECT_NEAR(y[1999], 1000, 20);  // a second later: nothing was wound up
}

TEST(GainSearch, FlyingScoringAndChoosingMakesABadStartBetterAndEnds) {
  const std::vector<LagPlant> plants{kLoop.up, kLoop.down};
  const Eigen::VectorXd wanted = set_point();
  std::vector<FlownGains> flown;
  PidnGains gains{1e-4, 0.002, 0, 0};  // sluggish
  for (int round = 0; round < 60; ++round) {
    const LoopScore s = score(wanted, simulated(kLoop, gains, wanted));
    ASSERT_TRUE(s.bounded);
    flown.push_back({gains, s.mean_error});
    const auto next = next_gains(flown, plants, {.control_period_s = 0.002});
    ASSERT_TRUE(next) << next.error().text();
    if (!*next) break;
    gains = **next;
  }
  double best = flown.front().score;
  for (const FlownGains& f : flown) {
    best = std::min(best, f.score);
    for (const LagPlant& p : plants) EXPECT_LE(margins(f.gains, p, 0.002).max_sensitivity, 2.0);
  }
  EXPECT_LT(flown.size(), 60u);
  EXPECT_LT(best, 0.6 * flown.front().score);
  // and no worse than what the model alone proposes
  const auto tuned = tune_pidn(plants, {.control_period_s = 0.002});
  ASSERT_TRUE(tuned);
  EXPECT_LE(best, 1.02 * score(wanted, simulated(kLoop, tuned->gains, wanted)).mean_error);
}

TEST(GainSearch, GoesOnFromAListAsIfItHadNeverStopped) {
  const std::vector<LagPlant> plants{kLoop.up};
  const std::vector<FlownGains> flown{{{4e-4, 0.01, 0, 0}, 10}, {{6e-4, 0.01, 0, 0}, 8}};
  const auto first = next_gains(flown, plants), again = next_gains(flown, plants);
  ASSERT_TRUE(first && *first && again && *again);
  EXPECT_EQ((**first).kp, (**again).kp);
  EXPECT_NEAR((**first).kp, 9e-4, 1e-12);  // the best so far, half as much again
}

TEST(GainSearch, RefusesListsThatTellNothing) {
  const std::vector<LagPlant> plants{kLoop.up};
  EXPECT_FALSE(next_gains({}, plants));
  EXPECT_FALSE(next_gains({{{std::nan(""), 0, 0, 0}, 1}}, plants));
  EXPECT_FALSE(next_gains({{{1e-4, 0, 0, 0}, 1}}, {}));
}

}  // namespace
}  // namespace omniflight::identification
