#include <gtest/gtest.h>

#include "bench.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/timing.hpp"

namespace omniflight::planning {
namespace {

std::vector<Pose> random_poses(Random& random, int n) {
  std::vector<Pose> out{{Vec3(0, 0, 1), exp_rotation(Vec3(0.3, -0.2, 0.1))}};
  for (int i = 1; i < n; ++i)
    out.push_back(
        {out.back().p_WB +
             Vec3(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6)),
         out.back().q_WB * exp_rotation(Vec3(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0.3))});
  return out;
}

TEST(PoseCurve, PassesThroughItsPosesWithTheDerivativesItStates) {
  Random random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const auto poses = random_poses(random, 2 + trial % 6);
    const PoseCurve curve(poses);
    for (const Pose& pose : poses) {
      double best = 1e9;
      for (int i = 0; i <= 4000; ++i) {
        const Reference r = curve.at(curve.length() * i / 4000, 0, 0);
        best = std::min(best, (r.p_WB - pose.p_WB).norm() + r.q_WB.angularDistance(pose.q_WB));
      }
      EXPECT_LT(best, 3e-3);
    }
    // u(t) = t^2 / 2: du = t, ddu = 1
    const double h = 1e-4;
    for (double t = 0.1; 0.5 * (t + h) * (t + h) < curve.length(); t += 0.05) {
      const auto at = [&](double time) { return curve.at(0.5 * time * time, time, 1.0); };
      const Reference r0 = at(t - h), r = at(t), r1 = at(t + h);
      EXPECT_LT(((r1.p_WB - r0.p_WB) / (2 * h) - r.v_WB_W).norm(), 1e-5);
      EXPECT_LT(((r1.v_WB_W - r0.v_WB_W) / (2 * h) - r.a_WB_W).norm(), 1e-2);
      EXPECT_LT((log_rotation(r0.q_WB.conjugate() * r1.q_WB) / (2 * h) - r.w_WB_B).norm(), 1e-4);
      EXPECT_LT(((r1.w_WB_B - r0.w_WB_B) / (2 * h) - r.dw_WB_B).norm(), 1e-2);
    }
  }
}

TEST(PoseCurve, TwoPosesGiveTheStraightLineAndTheShortestRotation) {
  const Pose a{Vec3(0, 0, 1), Quat::Identity()}, b{Vec3(1, 0, 1), exp_rotation(Vec3(0, 2.5, 0.5))};
  const PoseCurve curve({a, b});
  for (double s = 0; s <= 1.0; s += 0.1) {
    const Pose expected = interpolate(a, b, s);
    const Reference r = curve.at(s * curve.length(), 0, 0);
    EXPECT_LT((r.p_WB - expected.p_WB).norm(), 1e-12);
    EXPECT_LT(r.q_WB.angularDistance(expected.q_WB), 1e-7);
  }
}

TEST(Ride, KeepsEveryLimitAndOneOfThemTightly) {
  const auto v = omnimorph();
  const auto rotors = rotors_of(v, to_radians(50));
  Random random(12);
  for (int trial = 0; trial < 30; ++trial) {
    MotionLimits limits{.speed = random.uniform(0.2, 4),
                        .acceleration = random.uniform(0.3, 12),
                        .rate = random.uniform(0.3, 6),
                        .angular_acceleration = random.uniform(1, 60)};
    const auto knots = ride(PoseCurve(random_poses(random, 2 + trial % 4)), rotors, limits);
    ASSERT_TRUE(knots) << knots.error().text();
    const MotionPeaks p = peaks(*knots, rotors);
    const double use =
        std::max({p.speed / limits.speed, std::sqrt(p.acceleration / limits.acceleration),
                  p.rate / limits.rate, std::sqrt(p.angular_acceleration / limits.angular_acceleration)});
    EXPECT_LE(use, 1.0 + 1e-9);
    EXPECT_LE(p.rotor_load, 0.9 + 1e-9);
    EXPECT_GT(std::max(use, p.rotor_load / 0.9), 0.85);
    EXPECT_TRUE(knots->front().reference.v_WB_W.isZero(1e-12) && knots->back().reference.a_WB_W.isZero(1e-9));
  }
}

TEST(Ride, FewPlacesAskForNoMoreTimeThanAll) {
  // what is slower by few places than another ride by all of them is slower: by a knot's period, to which
  // times are found
  const auto rotors = rotors_of(omnimorph(), to_radians(50));
  Random random(13);
  for (int trial = 0; trial < 40; ++trial) {
    const MotionLimits limits{.speed = random.uniform(0.2, 4),
                              .acceleration = random.uniform(0.3, 12),
                              .rate = random.uniform(0.3, 6),
                              .angular_acceleration = random.uniform(1, 60)};
    const PoseCurve curve(random_poses(random, 3 + trial % 4));
    const auto few = least_time(curve, rotors, limits, {}, 50), all = least_time(curve, rotors, limits);
    ASSERT_TRUE(few && all);
    EXPECT_LE(*few - kKnotPeriod, *all);
    EXPECT_GT(*few, 0.8 * *all);
  }
}

TEST(Ride, AnAttitudeThatCannotBeHoveredIsNamed) {
  const auto rotors = rotors_of(omnimorph(), to_radians(15));
  const Pose level{Vec3(0, 0, 1), Quat::Identity()}, steep{Vec3(0, 0, 1), exp_rotation(Vec3(0, 1.3, 0))};
  const auto knots = ride(PoseCurve({level, steep}), rotors, {});
  ASSERT_FALSE(knots);
  EXPECT_NE(knots.error().text().find("alpha 15.0 deg"), std::string::npos) << knots.error().text();
}

TEST(SpeedBound, HoldsBetweenKnotsEvenWhenTheKnotsThemselvesAreSlow) {
  Random random(13);
  const auto draw = [&](double size) {
    return Vec3(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size));
  };
  for (int trial = 0; trial < 200; ++trial) {
    TrajectoryKnot k0, k1;
    k1.t = random.uniform(0.01, 1.0);
    for (auto* k : {&k0, &k1}) {
      k->reference = {draw(1), exp_rotation(draw(0.7)), draw(0.2), draw(0.3), draw(1), draw(1), 0.0};
    }
    const double radius = 0.33, bound = speed_bound(k0, k1, radius);
    const auto trajectory = Trajectory::create({k0, k1});
    ASSERT_TRUE(trajectory);
    for (int i = 0; i < 100; ++i) {
      const Reference r = trajectory->sample(k1.t * (i + 0.5) / 100);
      EXPECT_LE(r.v_WB_W.norm() + radius * r.w_WB_B.norm(), bound + 1e-6);
    }
  }
}

}  // namespace
}  // namespace omniflight::planning
