// The fastest speed along a curve, and rides near to it.
#include <gtest/gtest.h>

#include "bench.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/time_optimal.hpp"

namespace omniflight::planning {
namespace {

constexpr MotionLimits kRotorsAlone{
    .speed = 1e6, .acceleration = 1e6, .rate = 1e6, .angular_acceleration = 1e6};

std::vector<Pose> random_poses(Random& random, int n) {
  std::vector<Pose> out{{Vec3(0, 0, 1), Quat::Identity()}};
  const auto draw = [&](double size) -> Vec3 {
    return size * Vec3(random.normal(), random.normal(), random.normal()).normalized();
  };
  for (int i = 1; i < n; ++i)
    out.push_back({out.back().p_WB + draw(0.5), (out.back().q_WB * exp_rotation(draw(0.5))).normalized()});
  return out;
}

TEST(TimeOptimal, AStraightLineIsRiddenAtTheLimitsOfSpeedAndAcceleration) {
  const auto rotors = rotor_load(omnimorph(), to_radians(50));
  const PoseCurve line({{Vec3(0, 0, 1), Quat::Identity()}, {Vec3(2, 0, 1), Quat::Identity()}});
  MotionLimits limits = kRotorsAlone;
  limits.acceleration = 0.5;
  EXPECT_NEAR(time_optimal(line, rotors, limits, 400)->duration(), 2.0 * std::sqrt(2.0 / 0.5), 0.01);
  limits.speed = 0.5;  // m/s, reached after 1 s: 0.25 m on either side, and 1.5 m at that speed
  EXPECT_NEAR(time_optimal(line, rotors, limits, 400)->duration(), 5.0, 0.02);
}

TEST(TimeOptimal, TheBoundIsThatOfManyPlaces) {
  const auto rotors = rotor_load(omnimorph(), to_radians(50));
  Random random(3);
  for (int trial = 0; trial < 10; ++trial) {
    const PoseCurve curve(random_poses(random, 6));
    const double coarse = time_optimal(curve, rotors, kRotorsAlone, 200)->duration();
    EXPECT_NEAR(coarse, time_optimal(curve, rotors, kRotorsAlone, 1600)->duration(), 0.02 * coarse);
  }
}

TEST(TimeOptimal, TheProfileUsesALimitEverywhereAndExceedsNone) {
  const auto rotors = rotor_load(omnimorph(), to_radians(50));
  Random random(4);
  const PoseCurve curve(random_poses(random, 6));
  const SpeedProfile profile = time_optimal(curve, rotors, kRotorsAlone, 800).value();
  int idle = 0, over = 0;
  constexpr double kShort = 1e-6;  // s, so that the average is the profile
  for (int i = 1; i < 500; ++i) {
    const auto law = profile.averaged(profile.duration() * i / 500, kShort);
    const double load = rotors.motion_load(curve.at(law.u, law.du, law.ddu));
    idle += load<0.85, over += load> 0.92;
  }
  EXPECT_LT(idle, 25);
  EXPECT_LT(over, 25);
}

TEST(SpeedProfile, TheAverageHasTheDerivativesItStatesAndRestsAtItsEnds) {
  const SpeedProfile profile(1.0, {0.0, 0.5, 2.0, 0.7, 0.0});
  const double width = 0.2, end = profile.duration() + width, h = 1e-5;
  for (const double t : {0.0, end}) {
    const auto law = profile.averaged(t, width);
    EXPECT_NEAR(law.u, t > 0.0 ? 1.0 : 0.0, 1e-12);
    EXPECT_NEAR(std::abs(law.du) + std::abs(law.ddu), 0.0, 1e-9);
  }
  for (double t = 0.01; t < end - 0.01; t += 0.013) {
    const auto before = profile.averaged(t - h, width), now = profile.averaged(t, width),
               after = profile.averaged(t + h, width);
    EXPECT_NEAR((after.u - before.u) / (2 * h), now.du, 1e-6);
    EXPECT_NEAR((after.du - before.du) / (2 * h), now.ddu, 1e-3);
  }
}

TEST(RideShortest, KeepsEveryLimitNearTheBoundAndIsNeverSlowerThanMinimumJerk) {
  const auto rotors = rotors_of(omnimorph(), to_radians(50));
  Random random(5);
  for (int trial = 0; trial < 10; ++trial) {
    const PoseCurve curve(random_poses(random, 6));
    const auto slow = ride(curve, rotors, kRotorsAlone), fast = ride_shortest(curve, rotors, kRotorsAlone);
    ASSERT_TRUE(slow && fast);
    const MotionPeaks p = peaks(*fast, rotors);
    EXPECT_LE(p.rotor_load, 0.9);
    EXPECT_LE(p.thrust_rate.share, 0.9);
    EXPECT_LE(fast->back().t, slow->back().t);
    const double bound = time_optimal(curve, rotors.load(), kRotorsAlone)->duration();
    EXPECT_GE(fast->back().t, bound);
    EXPECT_LE(fast->back().t, 1.15 * bound);
    for (const auto* end : {&fast->front().reference, &fast->back().reference})
      EXPECT_LT(end->v_WB_W.norm() + end->a_WB_W.norm() + end->w_WB_B.norm() + end->dw_WB_B.norm(), 1e-6);
  }
}

}  // namespace
}  // namespace omniflight::planning
