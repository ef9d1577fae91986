#include <gtest/gtest.h>

#include <limits>

#include "omniflight_safety/missed_share.hpp"

namespace omniflight::safety {
namespace {

constexpr double kPeriod = 0.002;  // s

TEST(MissedShare, APeriodThatIsKeptMissesNothing) {
  MissedShare m;
  for (int k = 0; k < 5000; ++k) m.tick(3.0 + k * kPeriod, kPeriod);
  EXPECT_EQ(m.share(), 0.0);
}

TEST(MissedShare, LateTicksThatMissNoWholePeriodCountAsKept) {
  MissedShare m;
  for (int k = 0; k < 2000; ++k) m.tick(k * kPeriod + (k % 2 ? 0.9 * kPeriod : 0.0), kPeriod);
  EXPECT_EQ(m.share(), 0.0);
}

TEST(MissedShare, EveryTenthPeriodMissedIsATenth) {
  MissedShare m;
  for (int k = 0; k < 2000; ++k)
    if (k % 10 != 9) m.tick(k * kPeriod, kPeriod);
  EXPECT_NEAR(m.share(), 0.1, 0.005);
}

TEST(MissedShare, ASecondLaterItIsForgotten) {
  MissedShare m;
  m.tick(0, kPeriod);
  m.tick(0.05, kPeriod);
  EXPECT_GT(m.share(), 0.9);
  for (int k = 1; k < 600; ++k) m.tick(0.05 + k * kPeriod, kPeriod);
  EXPECT_EQ(m.share(), 0.0);
}

TEST(MissedShare, ASleepOfSecondsIsNearlyAll) {
  MissedShare m;
  for (int k = 0; k < 500; ++k) m.tick(k * kPeriod, kPeriod);
  m.tick(60.0, kPeriod);
  EXPECT_GT(m.share(), 0.99);
}

TEST(MissedShare, NonsenseIsIgnored) {
  MissedShare m;
  m.tick(std::numeric_limits<double>::quiet_NaN(), kPeriod);
  m.tick(1.0, 0.0);
  m.tick(1.0, -1.0);
  EXPECT_EQ(m.share(), 0.0);
  m.tick(5.0, kPeriod);
  m.tick(1.0, kPeriod);  // the clock ran back: anew
  m.tick(1.0 + kPeriod, kPeriod);
  EXPECT_EQ(m.share(), 0.0);
}

}  // namespace
}  // namespace omniflight::safety
