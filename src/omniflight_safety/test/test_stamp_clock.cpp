// Stamps of other clocks on flight time: followed by their least delay, and refused when they jump.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "omniflight_core/random.hpp"
#include "omniflight_safety/stamp_clock.hpp"

namespace omniflight::safety {
namespace {

constexpr double kUnix = 1.73e9;  // s

/// A source at 100 Hz whose samples take 5 ms and up to `jitter` more.
struct Source {
  StampClock clock{StampClockConfig{}};
  Random rng{7};
  double t = 20.0, jitter = 0.004, offset = kUnix, skew = 0;
  int refused = 0;
  double worst_s = 0;  ///< of placed stamps against when they were taken

  double stamp() const { return t + offset + skew * (t - 20.0); }
  std::optional<StampRefusal> next(double wrong_by = 0) {
    t += 0.01;
    double placed = std::nan("");
    const auto refusal = clock.place(stamp() + wrong_by, t + 0.005 + jitter * rng.uniform(), placed);
    refused += refusal.has_value();
    if (!refusal) worst_s = std::max(worst_s, std::abs(placed - t));
    return refusal;
  }
  void run(int samples) {
    for (int k = 0; k < samples; ++k) next();
  }
};

TEST(StampClock, FlightTimesOwnStampsStayAsTheyAre) {
  StampClock clock;
  double placed = 0;
  for (double t = 0; t < 5; t += 0.01) {
    EXPECT_FALSE(clock.place(t, t + 0.012, placed));
    EXPECT_EQ(placed, t);
  }
  EXPECT_FALSE(clock.foreign());
  EXPECT_EQ(clock.resets(), 0u);
}

TEST(StampClock, UnixTimeIsFollowedAfterAQuarterSecond) {
  Source s;
  s.run(500);
  EXPECT_TRUE(s.clock.foreign());
  EXPECT_EQ(s.clock.resets(), 1u);
  EXPECT_LE(s.refused, 27);
  EXPECT_GE(s.refused, 24) << "one stamp alone proves nothing";
  std::printf("UNIX stamps: %d refused before they are followed, placed to %.1f ms\n", s.refused,
              1e3 * s.worst_s);
  EXPECT_LT(s.worst_s, 0.0095) << "the least delay of 5 ms is not seen; jitter beyond it is";
  EXPECT_NE(s.clock.reset_words().find("1.73e+09"), std::string::npos) << s.clock.reset_words();
}

TEST(StampClock, OwnStampsThatComeTooLateAreNotFollowedAfterAnotherClock) {
  Source s;
  s.run(100);
  ASSERT_TRUE(s.clock.foreign());
  double placed = 0;
  for (int k = 0; k < 200; ++k) {
    s.t += 0.01;
    EXPECT_TRUE(s.clock.place(s.t - 2.0, s.t, placed)) << "of flight time, and 2 s late";
  }
  EXPECT_TRUE(s.clock.foreign());
  EXPECT_EQ(s.clock.resets(), 1u);
}

TEST(StampClock, AfterASilenceLongerThanTheWindowOnlyNewDelaysCount) {
  Source s;
  s.jitter = 0;
  s.run(100);
  const double before = s.clock.offset_s();
  s.t += 60;  // in which the clocks part by 9 ms: the stamps come later than any before
  s.offset -= 0.009;
  s.run(100);
  EXPECT_NEAR(s.clock.offset_s() - before, 0.009, 1e-4) << "a delay from before the silence held it back";
}

TEST(StampClock, DriftIsFollowedWithinItsBound) {
  for (const double skew : {5e-5, -5e-5}) {
    Source s;
    s.skew = skew;
    s.run(100);
    s.worst_s = 0;
    s.run(60000);  // 10 min, in which the clocks part by 30 ms
    EXPECT_EQ(s.clock.resets(), 1u);
    EXPECT_LT(s.worst_s, 0.0105) << "skew " << skew;
  }
}

TEST(StampClock, OneStampFromTheFutureIsRefusedByItsSizeAndMovesNothing) {
  for (const double offset : {0.0, kUnix}) {
    Source s;
    s.offset = offset;
    s.run(100);
    const double before = s.clock.offset_s();
    EXPECT_EQ(s.next(3.0), StampRefusal::from_future);
    EXPECT_NE(s.clock.refusal_words().find("s ahead of flight time"), std::string::npos);
    EXPECT_EQ(s.next(3600.0), StampRefusal::other_epoch);
    EXPECT_EQ(s.next(-2.0), StampRefusal::too_old);
    EXPECT_EQ(s.next(std::nan("")), StampRefusal::not_finite);
    EXPECT_FALSE(s.next());
    EXPECT_NEAR(s.clock.offset_s(), before, 1e-4);
  }
}

TEST(StampClock, AFutureOfOurOwnEpochIsRefusedForGood) {
  Source s;
  s.offset = 3.0;
  s.run(3000);
  EXPECT_EQ(s.refused, 3000);
}

TEST(StampClock, AStepOfAFollowedClockIsFollowedAnew) {
  for (const double step : {3600.0, -3600.0, 2.0, -2.0}) {
    Source s;
    s.run(100);
    s.refused = 0;
    s.offset += step;
    s.run(100);
    EXPECT_EQ(s.clock.resets(), 2u) << step;
    EXPECT_GE(s.refused, 24) << step;
    EXPECT_LE(s.refused, 27) << step;
    EXPECT_LT(s.worst_s, 0.0105) << step;
  }
}

TEST(StampClock, DataThatIsHeldUpIsNoOtherClock) {
  for (const double offset : {0.0, kUnix}) {
    StampClock clock;
    double placed = 0;
    int fresh = 0, held_up = 0;
    for (double t = 20; t < 25; t += 0.01) fresh += !clock.place(t + offset, t + 0.005, placed);
    // from here on every sample comes 1.5 s late, its stamps in a row with those before
    for (double t = 25; t < 35; t += 0.01) held_up += !clock.place(t + offset, t + 1.5, placed);
    for (double t = 35; t < 45; t += 0.01) held_up += !clock.place(t + offset, t + 15, placed);
    EXPECT_GT(fresh, 400);
    EXPECT_EQ(held_up, 0) << "a delay of 1.5 s would have passed as none";
  }
}

TEST(StampClock, ASourceThatReturnsToFlightTimeIsBelievedAgain) {
  Source s;
  s.run(100);
  s.offset = 0;
  s.run(100);
  EXPECT_FALSE(s.clock.foreign());
  EXPECT_EQ(s.clock.offset_s(), 0.0);
  EXPECT_EQ(s.clock.resets(), 2u);
}

TEST(StampClock, AClockThatIsAnotherOneForSureIsFollowedThoughItLiesNear) {
  StampClockConfig config;
  config.own = false;
  for (const double offset : {3.0, -3.0, 0.3, -0.3}) {
    StampClock clock(config);
    double placed = 0;
    int refused = 0;
    for (double t = 20; t < 25; t += 0.01) {
      if (clock.place(t + offset, t + 0.005, placed))
        ++refused;
      else
        EXPECT_NEAR(placed, t, 0.006);
    }
    EXPECT_LE(refused, 27) << offset;
  }
}

TEST(StampClock, AStampThatIsNeverSetIsNotFollowed) {
  StampClock clock;
  double placed = 0;
  for (double t = 20; t < 60; t += 0.01) EXPECT_TRUE(clock.place(0.0, t, placed));
  EXPECT_EQ(clock.resets(), 0u);
}

TEST(StampClock, RandomStampsAreNeverPlacedAheadOfNow) {
  Random rng(3);
  StampClock clock;
  double now = 0, placed = 0;
  int accepted = 0;
  for (int k = 0; k < 200000; ++k) {
    now += 0.01 * rng.uniform();
    const double base = rng.uniform() < 0.999 ? (k / 5000 % 2 == 0 ? 0.0 : kUnix) : 1e3 * rng.normal();
    if (clock.place(now + base - 0.02 * rng.uniform(), now, placed)) continue;
    ++accepted;
    EXPECT_LE(placed, now);
    EXPECT_GE(placed, now - StampClockConfig{}.old_s - 0.1);
  }
  EXPECT_GT(accepted, 190000);
}

TEST(StampClock, NonsenseIsRefused) {
  StampClockConfig c;
  EXPECT_TRUE(check(c));
  c.agree_s = 1;
  EXPECT_FALSE(check(c));
  c = {};
  c.window_s = 0;
  EXPECT_FALSE(check(c));
  c = {};
  c.drift = std::nan("");
  EXPECT_FALSE(check(c));
  c = {};
  c.epoch_s = 0.3;
  EXPECT_FALSE(check(c));
  c = {};
  c.old_s = -0.5;
  EXPECT_NE(check(c).error().text().find("old_s"), std::string::npos);
  StampClock clock;
  double placed = 0;
  EXPECT_EQ(clock.place(20.0, std::nan(""), placed), StampRefusal::not_finite);
}

}  // namespace
}  // namespace omniflight::safety
