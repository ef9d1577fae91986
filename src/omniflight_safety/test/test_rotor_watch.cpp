// Rotors that do not turn as commanded.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "omniflight_safety/rotor_watch.hpp"

namespace omniflight::safety {
namespace {

constexpr double kLag = 0.02, kPeriod = 0.002;  // s

RotorWatch two_rotors() { return RotorWatch({{1000, kLag, true}, {1000, kLag, false}}); }

/// Feeds a constant command and speeds until a rotor is lost; the time that took, or a negative number.
double lost_after(RotorWatch& watch, std::array<double, 2> command, std::array<double, 2> speed, double t = 0,
                  double until = 2) {
  for (double passed = 0; passed < until; passed += kPeriod)
    if (watch.add(t + passed, command, speed)) return passed;
  return -1;
}

TEST(RotorWatch, ARotorThatStandsIsLostOnceItsLagIsOver) {
  RotorWatch watch = two_rotors();
  EXPECT_NEAR(lost_after(watch, {600, 600}, {600, 100}), 0.05 + kLag, 2 * kPeriod);
  EXPECT_EQ(watch.lost(), 2u);
  EXPECT_NEAR(lost_after(watch, {600, 600}, {100, 100}, 1), 0.05 + kLag, 2 * kPeriod)
      << "commanded to one side for a second it cannot be reversing";
  EXPECT_EQ(watch.lost(), 3u);
}

TEST(RotorWatch, ARotorThatCouldBeReversingIsLostOnceThatWouldBeOver) {
  RotorWatch begins = two_rotors();
  EXPECT_NEAR(lost_after(begins, {600, 600}, {100, 600}), 0.10 + kLag, 2 * kPeriod)
      << "its sense is not known";
  EXPECT_EQ(begins.lost(), 1u);
  RotorWatch turns = two_rotors();
  EXPECT_LT(lost_after(turns, {600, 600}, {600, 600}, 0, 1), 0);
  // it is to pass 200 rad/s, slow commands tell nothing below, after its lag times ln 2, and 200 again after
  // ln 3
  const double due = kLag * std::log((600.0 + 600.0) / (600.0 - 200.0));
  EXPECT_NEAR(lost_after(turns, {-600, 600}, {0, 600}, 1), due + 0.10 + kLag, 3 * kPeriod);
}

TEST(RotorWatch, ARotorWithoutALagIsJudgedByItsCommandItself) {
  RotorWatch watch({{1000, 0, false}, {1000, 0, false}});
  EXPECT_LT(lost_after(watch, {0, 600}, {0, 600}, 0, 1), 0);
  EXPECT_NEAR(lost_after(watch, {600, 600}, {0, 600}, 1), 0.05, 2 * kPeriod);
  EXPECT_EQ(watch.lost(), 1u);
}

TEST(RotorWatch, SlowCommandsAndSpeedsWithoutASenseTellNothing) {
  RotorWatch watch = two_rotors();
  EXPECT_LT(lost_after(watch, {150, -600}, {0, 600}), 0)
      << "150 is too slow to tell; 600 has the wrong sign only";
  EXPECT_EQ(watch.lost(), 0u);
}

TEST(RotorWatch, AReversalIsNoLoss) {
  RotorWatch watch = two_rotors();
  double speed = 600;
  for (double t = 0; t < 4; t += kPeriod) {
    const double command = std::fmod(t, 0.5) < 0.25 ? 600 : -600;  // the lag's own answer, back and forth
    speed += (command - speed) * -std::expm1(-kPeriod / kLag);
    EXPECT_FALSE(watch.add(t, std::array{command, 600.0}, std::array{speed, 600.0})) << t;
  }
}

/// A rotor about zero thrust, as OmniMorph's rotor 4 once rotor 1 is lost: noise of the demand reverses its
/// command, a quarter of the largest speed in size, more often than it can turn round.
TEST(RotorWatch, ARotorThatIsReversedQuickerThanItTurnsIsNotLost) {
  RotorWatch watch = two_rotors();
  double speed = 0;
  int k = 0;
  for (double t = 0; t < 4; t += kPeriod, ++k) {
    const double command = k % 4 < 2 ? 250 : -250;
    speed += (command - speed) * -std::expm1(-kPeriod / kLag);
    ASSERT_LT(std::abs(speed), 0.25 * 250) << "the test asks nothing";
    EXPECT_FALSE(watch.add(t, std::array{command, 600.0}, std::array{speed, 600.0})) << t;
  }
  EXPECT_GT(lost_after(watch, {250, 600}, {0, 600}, 4), 0) << "commanded to one side it tells";
  EXPECT_EQ(watch.lost(), 1u);
}

TEST(RotorWatch, OnceLostItStaysLostUntilReset) {
  RotorWatch watch = two_rotors();
  EXPECT_GT(lost_after(watch, {600, 600}, {0, 600}), 0);
  EXPECT_LT(lost_after(watch, {0, 600}, {0, 600}, 3), 0);
  EXPECT_EQ(watch.lost(), 1u);
  watch.reset();
  EXPECT_EQ(watch.lost(), 0u);
}

TEST(RotorWatch, AnInterruptionIsNoTimeInWhichARotorWasSlow) {
  RotorWatch watch = two_rotors();
  EXPECT_LT(lost_after(watch, {600, 600}, {600, 100}, 0, 0.06), 0);
  watch.interrupt();
  EXPECT_NEAR(lost_after(watch, {600, 600}, {600, 100}, 1), 0.05 + kLag, 2 * kPeriod) << "counted anew";
  EXPECT_EQ(watch.lost(), 2u);
  watch.interrupt();
  EXPECT_EQ(watch.lost(), 2u) << "what is lost stays lost";
  EXPECT_NEAR(lost_after(watch, {600, 600}, {100, 600}, 2), 0.10 + kLag, 2 * kPeriod)
      << "it may have been reversing";
}

TEST(RotorWatch, TimesThatDoNotGoOnAreNotCounted) {
  RotorWatch watch = two_rotors();
  const std::array command{600.0, 600.0}, speed{0.0, 600.0};
  EXPECT_FALSE(watch.add(5.0, command, speed));
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(watch.add(5.0 - 0.01 * i, command, speed));
  EXPECT_TRUE(watch.add(5.2, command, speed)) << "slow since 5.0 s";
}

TEST(RotorWatch, BrokenSamplesChangeNothing) {
  RotorWatch watch = two_rotors();
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.001 * i;
    EXPECT_FALSE(watch.add(t, std::array{600.0}, std::array{0.0}));
    EXPECT_FALSE(watch.add(t, std::array{600.0, 600.0}, std::array{std::nan(""), 0.0}));
    EXPECT_FALSE(watch.add(t, std::array{std::nan(""), 600.0}, std::array{0.0, 0.0}));
    EXPECT_FALSE(watch.add(std::nan(""), std::array{600.0, 600.0}, std::array{0.0, 0.0}));
    EXPECT_FALSE(watch.add(t, std::array{600.0, 600.0}, std::array{0.0}));
  }
  EXPECT_EQ(watch.lost(), 0u);
}

}  // namespace
}  // namespace omniflight::safety
