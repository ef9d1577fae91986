// Host time from 8-bit sequence numbers, against a simulated board clock and line.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <omniflight_core/random.hpp>

#include "omniflight_gateway/sequence_clock.hpp"

namespace omniflight::gateway {
namespace {

TEST(SequenceClock, TakesTheJitterOutOfTheArrivals) {
  Random random(4, "line");
  SequenceClock clock(1000.0);
  double worst_s = 0.0, worst_arrival_s = 0.0, previous_s = -1.0;
  for (int i = 0; i < 20000; ++i) {
    const double sent_s = 100.0 + i * 1e-3 * (1 + 2e-4);  // the board's crystal is 200 ppm slow
    const double delay_s = 2e-4 - 3e-4 * std::log(1 - random.uniform());
    const double arrival_s = sent_s + std::min(delay_s, 4e-3);
    const auto stamp = clock.stamp(static_cast<std::uint8_t>(i), arrival_s);
    EXPECT_LE(stamp.time_s, arrival_s + 1e-9);
    EXPECT_EQ(stamp.missed, 0u);
    if (i > 1000) {
      worst_s = std::max(worst_s, std::abs(stamp.time_s - sent_s - 2e-4));
      worst_arrival_s = std::max(worst_arrival_s, std::abs(arrival_s - sent_s - 2e-4));
      EXPECT_GT(stamp.time_s, previous_s);
    }
    previous_s = stamp.time_s;
  }
  EXPECT_LT(worst_s, 2e-4);
  EXPECT_GT(worst_arrival_s, 2e-3);  // what it had to work with
}

TEST(SequenceClock, CountsLostSamplesAcrossTheWrapAndDropsDuplicates) {
  SequenceClock clock(100.0);
  EXPECT_EQ(clock.stamp(250, 1.0).missed, 0u);
  EXPECT_EQ(clock.stamp(251, 1.01).missed, 0u);
  EXPECT_TRUE(clock.stamp(251, 1.011).duplicate);
  const auto after_gap = clock.stamp(2, 1.08);  // 252..255, 0, 1 are missing
  EXPECT_EQ(after_gap.missed, 6u);
  EXPECT_NEAR(after_gap.time_s, 1.08, 1e-3);
  EXPECT_EQ(clock.missed(), 6u);
  EXPECT_EQ(clock.received(), 3u);
}

TEST(SequenceClock, ALongGapOrAWrongRateStartsAnew) {
  SequenceClock clock(1000.0);
  clock.stamp(0, 10.0);
  EXPECT_NEAR(clock.stamp(100, 20.0).time_s, 20.0, 1e-12);
  SequenceClock wrong(1000.0);  // the board really sends at 500 Hz
  for (int i = 0; i < 1000; ++i) {
    const double arrival_s = i * 2e-3;
    EXPECT_LE(arrival_s - wrong.stamp(static_cast<std::uint8_t>(i), arrival_s).time_s, 5e-3 + 1e-9);
  }
}

}  // namespace
}  // namespace omniflight::gateway
