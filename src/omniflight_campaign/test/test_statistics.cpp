// Intervals against published figures, and against how often they cover what is true.
#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_campaign/statistics.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::campaign {
namespace {

TEST(Share, IsWilsonsInterval) {
  for (const std::size_t n : {1u, 7u, 2000u}) {
    EXPECT_EQ(share(0, n).low, 0) << n;
    EXPECT_EQ(share(n, n).high, 1) << n;
  }
  // Newcombe 1998, Statistics in Medicine 17, 857-872, table I, method 3
  const Estimate a = share(81, 263);
  EXPECT_NEAR(a.low, 0.2553, 5e-5);
  EXPECT_NEAR(a.high, 0.3662, 5e-5);
  const Estimate b = share(15, 148);
  EXPECT_NEAR(b.low, 0.0624, 5e-5);
  EXPECT_NEAR(b.high, 0.1605, 5e-5);
  const Estimate c = share(0, 20);
  EXPECT_EQ(c.low, 0);
  EXPECT_NEAR(c.high, 0.1611, 5e-5);
  EXPECT_NEAR(share(29, 29).low, 0.8830, 5e-5);
  EXPECT_TRUE(std::isnan(share(0, 0).value));
}

TEST(Mean, IsStudentsInterval) {
  const double values[] = {1, 2, 3, 4, 5};
  const Estimate m = mean(values);
  EXPECT_EQ(m.value, 3);
  EXPECT_NEAR(m.high - m.value, 2.776 * std::sqrt(2.5 / 5), 1e-12);
  EXPECT_TRUE(std::isnan(mean(std::span(values).first(1)).low));
}

TEST(Quantile, IsBetweenOrderStatistics) {
  std::vector<double> values;
  for (int k = 1; k <= 100; ++k) values.push_back(101 - k);
  const Estimate median = quantile(values, 0.5);
  EXPECT_EQ(median.value, 50);
  // binomial(100, 1/2): P(B <= 39) = 0.0176, P(B <= 40) = 0.0284; P(B <= 60) = 0.9824
  EXPECT_EQ(median.low, 40);
  EXPECT_EQ(median.high, 61);
  // a hundred flights say nothing of the upper end of the 99 % quantile: 0.99^100 = 0.37 that none lies above
  EXPECT_EQ(quantile(values, 0.99).high, HUGE_VAL);
}

TEST(Quantile, CoversTheTruthInNineteenOfTwenty) {
  Random random(4);
  int covers_median = 0, covers_tail = 0, covers_mean = 0;
  constexpr int kTimes = 2000;
  for (int k = 0; k < kTimes; ++k) {
    std::vector<double> values;
    for (int i = 0; i < 200; ++i) values.push_back(-std::log(1 - random.uniform()));  // exponential
    const Estimate median = quantile(values, 0.5), tail = quantile(values, 0.95), m = mean(values);
    covers_median += median.low <= std::log(2.0) && std::log(2.0) <= median.high;
    covers_tail += tail.low <= -std::log(0.05) && -std::log(0.05) <= tail.high;
    covers_mean += m.low <= 1 && 1 <= m.high;
  }
  // three standard errors of a share of 0.95 are 0.015; discrete intervals cover at least what they promise
  EXPECT_GT(covers_median, 0.935 * kTimes);
  EXPECT_LT(covers_median, 0.985 * kTimes);
  EXPECT_GT(covers_tail, 0.935 * kTimes);
  EXPECT_LT(covers_tail, 0.985 * kTimes);
  EXPECT_GT(covers_mean, 0.925 * kTimes);
  EXPECT_LT(covers_mean, 0.97 * kTimes);
}

TEST(Ranks, ShareAMeanRankWhereTheyTie) {
  const double values[] = {5, 1, 5, 9};
  EXPECT_EQ(ranks(values), (std::vector<double>{2.5, 1, 2.5, 4}));
}

}  // namespace
}  // namespace omniflight::campaign
