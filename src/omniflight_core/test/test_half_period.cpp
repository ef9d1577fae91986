#include "omniflight_core/half_period.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace omniflight {
namespace {

TEST(HalfPeriod, QuantisesTheSpeedAsTheBoardsDo) {
  // Measured on the boards' own host software: asked -> flown, Hz.
  for (const auto& [asked, flown] :
       {std::pair{60.0, 60.0024}, {120.0, 120.019}, {180.0, 180.050}, {240.0, 240.038}, {300.0, 300.120}}) {
    const double w = speed_from_half_period(half_period_from_speed(2 * kPi * asked));
    EXPECT_NEAR(w / (2 * kPi), flown, 5e-4);
    EXPECT_DOUBLE_EQ(speed_from_half_period(half_period_from_speed(-2 * kPi * asked)), -w);
  }
}

TEST(HalfPeriod, SlowerThanItCanSayMeansStop) {
  EXPECT_NEAR(kSlowestSpeed / (2 * kPi), 15.259, 5e-4);
  EXPECT_EQ(half_period_from_speed(0.0), kStopHalfPeriod);
  EXPECT_EQ(half_period_from_speed(kSlowestSpeed * 0.99999), kStopHalfPeriod);
  EXPECT_EQ(half_period_from_speed(-kSlowestSpeed * 0.99999), -kStopHalfPeriod);
  EXPECT_EQ(half_period_from_speed(kSlowestSpeed * 1.0001), 32763);
  EXPECT_EQ(half_period_from_speed(std::nan("")), kStopHalfPeriod);
  EXPECT_EQ(half_period_from_speed(1e300), 1);
  EXPECT_EQ(half_period_from_speed(-INFINITY), -1);
  for (const std::int16_t stop : {0, 32767, -32767, -32768}) {
    EXPECT_EQ(speed_from_half_period(stop), 0.0);
  }
}

TEST(HalfPeriod, SurvivesTheWayThereAndBack) {
  for (int v = 1; v < kStopHalfPeriod; ++v) {
    for (const int sign : {1, -1}) {
      const auto half_period = static_cast<std::int16_t>(sign * v);
      ASSERT_EQ(half_period_from_speed(speed_from_half_period(half_period)), half_period);
    }
  }
}

}  // namespace
}  // namespace omniflight
