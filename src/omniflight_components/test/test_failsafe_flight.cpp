// Flights with somebody who spoils them: strangers on the bus, poses that stop or freeze, an operator.
#include "spoiled_flight.hpp"

namespace {

TEST_F(FailsafeFlight, PosesOfAnotherClockBlindNobody) {
  // the first pose of all is the stranger's, so that the one who is followed speaks another time
  const Flown flown = fly([](Stranger& s, double t) {
    if (t > 2.0 && t < 2.1) s.pose(1.7e9 + t, 0.0);
    if (t > 2.1 && t < 2.2) s.pose(t + 5.0, 0.0);
  });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight);
  EXPECT_SAYS(flown, "a second publisher of /omniflight/mocap is refused");
}

TEST_F(FailsafeFlight, ASecondPublisherOfPosesIsNotFollowed) {
  const Flown flown = fly([](Stranger& s, double t) {
    if (t > 2.0) s.pose(t, 2.0);
  });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight);
  EXPECT_SAYS(flown, "a second publisher of /omniflight/mocap is refused");
}

TEST_F(FailsafeFlight, ASecondPublisherOfCommandsIsNotFollowed) {
  const Flown flown = fly([](Stranger& s, double t) {
    if (t > 2.0) s.command(t + 1e-6, 0.0);
  });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight);
  EXPECT_SAYS(flown, "a second publisher of /omniflight/command is refused");
}

TEST_F(FailsafeFlight, AGapOfPosesIsFlownThrough) {
  const Flown flown = fly({}, "  - {at_s: 3, kind: sensor_loss, sensor: mocap, for_s: 0.3}\n");
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_LT(flown.seen->furthest_m, kQuietFlight);
  EXPECT_TRUE(flown.seen->failsafe.empty());
}

TEST_F(FailsafeFlight, LostPosesAreFlownThroughForHalfASecondThenDescended) {
  const Flown flown = fly({}, "  - {at_s: 3, kind: sensor_loss, sensor: mocap, for_s: 60}\n", 12);
  EXPECT_EQ(flown.code, kIncomplete) << flown.text;
  ASSERT_GE(flown.seen->failsafe.size(), 2u) << flown.text;
  const auto& descend = flown.seen->failsafe[0];
  EXPECT_EQ(descend.words, "descend: pose_lost");
  constexpr double kFrame = 0.012;  // s between two poses, and their delay
  EXPECT_NEAR(descend.t, 3.5, kFrame + kPeriod);
  const auto& ramp = flown.seen->failsafe[1];
  EXPECT_EQ(ramp.words, "ramp_down: pose_lost");
  const Vec3 moved = flown.seen->last - flown.seen->first;
  std::printf("descended from 1.3 m to %.2f m in %.2f s, %.2f m aside on the IMU alone\n",
              flown.seen->last.z(), ramp.t - descend.t, moved.head<2>().norm());
  EXPECT_LT(moved.head<2>().norm(), 0.5);
  EXPECT_NEAR(flown.seen->last.z(), 0.1, 0.3);
  EXPECT_SAYS(flown, "the failsafe ended the flight");
}

TEST_F(FailsafeFlight, TheFilterKnowsTheBiasesWhenPosesAreLost) {
  double aside[2];
  for (const int k : {0, 1}) {
    const Flown flown =
        fly({}, "  - {at_s: 5, kind: sensor_loss, sensor: mocap, for_s: 60}\n", 12,
            {std::string("controller:estimator:=") + (k == 0 ? "fixed_gain" : "error_state")});
    EXPECT_EQ(flown.code, kIncomplete) << flown.text;
    EXPECT_SAYS(flown, "descend: pose_lost");
    aside[k] = (flown.seen->last - flown.seen->first).head<2>().norm();
  }
  std::printf("descended on the IMU alone: %.2f m aside with the observer, %.2f m with the filter\n",
              aside[0], aside[1]);
  EXPECT_LT(aside[1], aside[0]);
}

TEST_F(FailsafeFlight, FrozenPosesAreRefusedAndThenDescended) {
  const Flown flown = fly({}, "  - {at_s: 3, kind: sensor_freeze, sensor: mocap, for_s: 60}\n", 12);
  EXPECT_EQ(flown.code, kIncomplete) << flown.text;
  EXPECT_SAYS(flown, "equal poses in a row");
  EXPECT_SAYS(flown, "descend: pose_lost");
  EXPECT_LT((flown.seen->last - flown.seen->first).head<2>().norm(), 0.5);
}

TEST_F(FailsafeFlight, AFrozenImuIsNotFlownOnUntilTheVehicleIsLost) {
  const Flown flown = fly({}, "  - {at_s: 5, kind: sensor_freeze, sensor: imu, for_s: 60}\n", 12);
  EXPECT_EQ(flown.code, kIncomplete) << flown.text;
  std::printf("frozen IMU: %s at %.2f s, %.2f m off\n", story(flown).c_str(), flown.seen->end_s,
              flown.seen->furthest_m);
  EXPECT_SAYS(flown, "ramp_down: estimate_diverged");
  EXPECT_LT(flown.seen->furthest_m, 1.0);
}

TEST_F(FailsafeFlight, TheOperatorHoldsAndResumes) {
  const auto at = [](double t, double when) { return std::abs(t - when) < 0.5 * kPeriod; };
  const Flown flown = fly(
      [&](Stranger& s, double t) {
        if (at(t, 4.5)) s.wish("hold");
        if (at(t, 5.5)) s.wish("none");
      },
      "", 10);
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_EQ(story(flown), "hold: operator_hold, fly");
  ASSERT_EQ(flown.seen->failsafe.size(), 2u);
  EXPECT_NEAR(flown.seen->failsafe[0].t, 4.5, 1.5 * kPeriod);
  EXPECT_NEAR(flown.seen->failsafe[1].t, 5.5, 1.5 * kPeriod);
  EXPECT_NEAR((flown.seen->last - flown.seen->first).x(), 0.05, 0.01)
      << "the plan was flown to its end afterwards";
}

TEST_F(FailsafeFlight, TheOperatorLands) {
  const Flown flown = fly(
      [](Stranger& s, double t) {
        if (std::abs(t - 3.0) < 0.5 * kPeriod) s.wish("land");
      },
      "", 12);
  EXPECT_EQ(flown.code, kIncomplete) << flown.text;
  EXPECT_EQ(story(flown).substr(0, 50), "descend: operator_land, ramp_down: operator_land");
  EXPECT_LT(flown.seen->last.z(), 0.2);
  EXPECT_LT((flown.seen->last - flown.seen->first).head<2>().norm(), 0.05)
      << "the mission's clearance is 0.08 m";
}

TEST_F(FailsafeFlight, OutsideTheFenceItDescends) {
  const Flown flown =
      fly({}, "", 14, {"controller:fence_min_m:=[-1, -1, -1]", "controller:fence_max_m:=[0.03, 1, 3]"});
  EXPECT_EQ(flown.code, kIncomplete) << flown.text;
  EXPECT_EQ(story(flown).substr(0, 22), "descend: geofence_left");
}

TEST_F(FailsafeFlight, AnEmptyBatteryIsLandedWith) {
  const Flown flown = fly({}, "", 12, {"controller:battery_empty_V:=900"});
  EXPECT_EQ(flown.code, kIncomplete) << flown.text;
  ASSERT_FALSE(flown.seen->failsafe.empty());
  EXPECT_EQ(flown.seen->failsafe[0].words, "descend: battery_empty");
  EXPECT_NEAR(flown.seen->failsafe[0].t, 1.5, 1.5 * kPeriod) << "1 s held, then 0.5 s";
}

}  // namespace
