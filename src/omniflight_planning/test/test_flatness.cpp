#include <gtest/gtest.h>

#include "bench.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/flatness.hpp"
#include "quadrotor.hpp"

namespace omniflight::planning {
namespace {

/// A smooth motion far from rest, with all its derivatives.
FlatMotion motion_at(double t) {
  FlatMotion m;
  const double amplitude[4] = {1.0, 0.7, 0.4, 0.9}, rate[4] = {1.3, 1.7, 2.1, 0.8}, phase[4] = {0, 1, 2, 3};
  for (std::size_t k = 0; k < 5; ++k)
    for (int i = 0; i < 4; ++i)
      m[k][i] = amplitude[i] * std::pow(rate[i], static_cast<double>(k)) *
                std::sin(rate[i] * t + phase[i] + 0.5 * kPi * static_cast<double>(k));
  return m;
}

const FlatVehicle kVehicles[] = {{Vec3::UnitZ(), Vec3::Zero()},
                                 {Vec3(0.3, -0.2, 1).normalized(), Vec3(0.02, -0.01, 0.03)},
                                 {-Vec3::UnitX(), Vec3(0, 0, 0.05)}};

TEST(Flatness, RatesAreTheDerivativesOfTheMotion) {
  constexpr double h = 1e-5;
  for (const FlatVehicle& vehicle : kVehicles)
    for (double t = 0; t < 6; t += 0.37) {
      const Reference r = flat_reference(motion_at(t), vehicle),
                      before = flat_reference(motion_at(t - h), vehicle),
                      after = flat_reference(motion_at(t + h), vehicle);
      EXPECT_LT(((after.p_WB - before.p_WB) / (2 * h) - r.v_WB_W).norm(), 1e-7);
      EXPECT_LT(((after.v_WB_W - before.v_WB_W) / (2 * h) - r.a_WB_W).norm(), 1e-7);
      EXPECT_LT((log_rotation(before.q_WB.conjugate() * after.q_WB) / (2 * h) - r.w_WB_B).norm(), 1e-7);
      EXPECT_LT(((after.w_WB_B - before.w_WB_B) / (2 * h) - r.dw_WB_B).norm(), 1e-7);
    }
}

TEST(Flatness, TheThrustPointsAlongWhatTheMotionNeeds) {
  for (const FlatVehicle& vehicle : kVehicles)
    for (double t = 0; t < 6; t += 0.37) {
      const FlatMotion m = motion_at(t);
      const Reference r = flat_reference(m, vehicle);
      const Vec3 thrust = m[2].head<3>() + kGravity * Vec3::UnitZ();
      EXPECT_LT((r.q_WB * vehicle.thrust_axis_B - thrust.normalized()).norm(), 1e-12);
      EXPECT_LT((r.p_WB + r.q_WB * vehicle.p_BBcm - m[0].head<3>()).norm(), 1e-12);
    }
}

TEST(Flatness, TheRotorsOfAQuadrotorGiveEveryFlatMotion) {
  auto v = quadrotor();
  v.center_of_mass = Vec3(0.01, -0.02, 0.03);
  const auto rotors = rotor_load(v, 0);
  const auto flat = flat_vehicle(v, 0).value();
  ASSERT_TRUE(flat);
  for (double t = 0; t < 6; t += 0.1) {
    const auto inertial = rotors.inertial_wrench(flat_reference(motion_at(t), *flat));
    EXPECT_LT(inertial.unreachable_B.norm(), 1e-9);
    EXPECT_GT(inertial.size, 0.1);
  }
  EXPECT_FALSE(flat_vehicle(omnimorph(), to_radians(30)).value()) << "it need not lean";
  EXPECT_TRUE(flat_vehicle(omnimorph(), 0.0).value()) << "all its rotors are parallel at 0 deg";
}

TEST(Flatness, KnowsTheHeadingsInWhichItCanRest) {
  for (const FlatVehicle& vehicle : kVehicles)
    for (const double heading : {-3.0, -0.4, 0.0, 1.0, 3.1}) {
      const Quat q = vehicle.upright(heading);
      EXPECT_LT(vehicle.lean(q), 1e-9);
      EXPECT_NEAR(vehicle.heading(q).value(), heading, 1e-9);
      EXPECT_FALSE(vehicle.heading(exp_rotation(Vec3(0.01, 0, 0)) * q));
      EXPECT_NEAR(vehicle.lean(exp_rotation(Vec3(0.01, 0, 0)) * q), 0.01, 1e-9);
    }
}

TEST(FlatCurve, PassesThroughItsPosesAndIsSmooth) {
  Random random(4, "flat");
  const FlatVehicle& vehicle = kVehicles[1];
  for (std::size_t count = 2; count < 12; ++count) {
    std::vector<Pose> poses;
    for (std::size_t k = 0; k < count; ++k)
      poses.push_back(
          {Vec3(0.3 * static_cast<double>(k) + random.uniform(0, 0.1), random.uniform(), random.uniform()),
           vehicle.upright(random.uniform(-3, 3))});
    const FlatCurve curve(poses, vehicle);
    const auto near = [&](const Pose& pose, double u) {
      const Eigen::Vector4d x = curve.at(u)[0];
      const double turn = std::remainder(x[3] - vehicle.heading(pose.q_WB).value(), 2 * kPi);
      return (x.head<3>() - pose.p_WB - pose.q_WB * vehicle.p_BBcm).norm() + std::abs(turn);
    };
    EXPECT_LT(near(poses.front(), 0), 1e-9);
    EXPECT_LT(near(poses.back(), curve.length()), 1e-9);
    for (const Pose& pose : poses) {
      double least = 1e9;
      for (int i = 0; i <= 20000; ++i) least = std::min(least, near(pose, curve.length() * i / 20000));
      EXPECT_LT(least, 1e-2);
    }
    const double h = 1e-5 * curve.length();
    for (int i = 1; i < 50; ++i) {
      const double u = curve.length() * i / 50;
      const FlatMotion m = curve.at(u), before = curve.at(u - h), after = curve.at(u + h);
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_LT(((after[k] - before[k]) / (2 * h) - m[k + 1]).norm(), 1e-3 * (1 + m[k + 1].norm())) << k;
    }
  }
}

TEST(FlatRide, KeepsEveryLimitAndStartsAndEndsAtRest) {
  const auto v = quadrotor();
  const auto rotors = rotors_of(v, 0);
  const FlatVehicle flat = flat_vehicle(v, 0).value().value();
  std::vector<Pose> poses{{Vec3(0, 0, 1), flat.upright(0)},
                          {Vec3(1, 0.5, 1.2), flat.upright(0.5)},
                          {Vec3(2, 0, 1), flat.upright(1)}};
  MotionLimits limits;
  limits.speed = 2, limits.acceleration = 4, limits.rate = 2, limits.angular_acceleration = 20;
  double slowest = 0;
  for (const double lean_deg : {30.0, 10.0, 3.0}) {
    limits.lean = to_radians(lean_deg);
    const auto knots = ride(FlatCurve(poses, flat), flat, rotors, limits);
    ASSERT_TRUE(knots) << knots.error().text();
    const MotionPeaks p = peaks(*knots, rotors);
    EXPECT_LE(p.speed, limits.speed);
    EXPECT_LE(p.acceleration, limits.acceleration);
    EXPECT_LE(p.rate, limits.rate);
    EXPECT_LE(p.angular_acceleration, limits.angular_acceleration);
    EXPECT_LE(p.rotor_load, 0.9);
    EXPECT_LE(largest_lean(*knots, flat), limits.lean);
    EXPECT_GT(knots->back().t, slowest) << "a smaller lean takes longer";
    slowest = knots->back().t;
    for (const Reference& r : {knots->front().reference, knots->back().reference})
      EXPECT_LT(r.v_WB_W.norm() + r.a_WB_W.norm() + r.w_WB_B.norm() + r.dw_WB_B.norm(), 1e-9);
    const auto trajectory = Trajectory::create(*knots);
    ASSERT_TRUE(trajectory);
    for (double t = 0.005; t < trajectory->duration(); t += 0.1) {  // between the knots, too
      const auto inertial = rotors.load().inertial_wrench(trajectory->sample(t));
      EXPECT_LT(inertial.unreachable_B.norm(), 1e-3 * (1 + inertial.size)) << t;
    }
  }
}

}  // namespace
}  // namespace omniflight::planning
