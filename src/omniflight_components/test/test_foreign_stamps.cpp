// Flights whose poses, inertial samples or commands are stamped by another clock, or wrongly.
#include "spoiled_flight.hpp"

namespace {

constexpr const char* kNoOtherMocap = "  - {at_s: 0, kind: sensor_loss, sensor: mocap, for_s: 60}\n";
constexpr double kUnix = 1.7e9;  // s

TEST_F(FailsafeFlight, PosesStampedInUnixTimeAreFlownWith) {
  const Flown flown =
      fly({}, kNoOtherMocap, 8, {}, [](Stranger& s) { s.play_mocap([](double t) { return kUnix + t; }); });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight);
  EXPECT_NEAR((flown.seen->last - flown.seen->first).x(), 0.05, 0.01);
  EXPECT_SAYS(flown, "poses: another clock is followed, 1.7e+09 s from flight time");
}

TEST_F(FailsafeFlight, OutliersBelowTheJumpTestAreRefusedByTheFilter) {
  double sideways[2];
  for (const int k : {0, 1}) {
    const Flown flown = fly(
        {}, kNoOtherMocap, 8,
        {std::string("controller:estimator:=") + (k == 0 ? "fixed_gain" : "error_state")}, [](Stranger& s) {
          s.play_mocap([](double t) { return t; });
          s.outlier_m = [](double t) { return t > 2.0 && std::fmod(t, 0.1) < 0.004 ? 0.25 : 0.0; };
        });
    EXPECT_EQ(flown.code, 0) << flown.text;
    sideways[k] = flown.seen->sideways_m;
  }
  std::printf(
      "an outlier of 0.25 m every 0.1 s: %.1f mm sideways with the observer, %.1f mm with the filter\n",
      1e3 * sideways[0], 1e3 * sideways[1]);
  EXPECT_LT(sideways[1], 0.002);
  EXPECT_LT(sideways[1], 0.5 * sideways[0]);
}

TEST_F(FailsafeFlight, AnImuStampedInUnixTimeIsFlownWith) {
  const Flown flown =
      fly({}, "  - {at_s: 0, kind: sensor_loss, sensor: imu, for_s: 60}\n", 8, {}, [](Stranger& s) {
        s.play_imu([](double t) { return kUnix + t + (t > 4.0 && t < 4.003 ? 5.0 : 0.0); });
      });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight);
  EXPECT_SAYS(flown, "IMU: another clock is followed, 1.7e+09 s from flight time");
  EXPECT_SAYS(flown, "IMU samples refused, the last: stamp 5 s ahead of flight time");
}

TEST_F(FailsafeFlight, AFutureStampAmongUnixTimeIsRefusedBySize) {
  const Flown flown = fly({}, kNoOtherMocap, 8, {}, [](Stranger& s) {
    s.play_mocap([](double t) { return kUnix + t + (t > 4.0 && t < 4.01 ? 5.0 : 0.0); });
  });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight);
  EXPECT_SAYS(flown, "poses refused, the last: stamp 5 s ahead of flight time");
}

TEST_F(FailsafeFlight, AMocapClockThatIsSetInFlightIsFollowedAnew) {
  for (const double step : {3600.0, -2.0}) {
    const Flown flown = fly({}, kNoOtherMocap, 8, {}, [&](Stranger& s) {
      s.play_mocap([step](double t) { return kUnix + t + (t > 4.0 ? step : 0.0); });
    });
    EXPECT_EQ(flown.code, 0) << flown.text;
    EXPECT_LT(flown.seen->furthest_m, kQuietFlight) << step;
    EXPECT_SAYS(flown, "poses refused, the last: stamp");
    EXPECT_TRUE(story(flown).find("descend") == std::string::npos) << story(flown);
  }
}

TEST_F(FailsafeFlight, PosesOfTheFutureOfFlightTimeAreNeverFlownWith) {
  const Flown flown = fly({}, kNoOtherMocap, 12, {}, [](Stranger& s) {
    s.play_mocap([](double t) { return t + (t > 3.0 ? 3.0 : 0.0); });
  });
  EXPECT_EQ(flown.code, kIncomplete) << flown.text;
  EXPECT_SAYS(flown, "s ahead of flight time");
  EXPECT_SAYS(flown, "descend: pose_lost");
}

TEST_F(FailsafeFlight, ACommandOfAnotherEpochAnswersNoTick) {
  // the stranger speaks before the first tick, so that it is the one who is followed, until it is silent
  const Flown flown = fly({}, "", 8, {}, [](Stranger& s) { s.first_word_s = kUnix; });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight) << "the first tick waits for the allocator";
  EXPECT_SAYS(flown, "a command stamped 1.7e+09 s ahead of the newest tick is refused (1 so far)");
}

}  // namespace
