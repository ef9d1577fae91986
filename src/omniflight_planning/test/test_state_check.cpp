#include <gtest/gtest.h>

#include "bench.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::planning {
namespace {

TEST(WrenchLimits, ForceHullAtZeroTorqueHasTheClosedForm) {
  auto v = omnimorph();
  v.center_of_mass.setZero();
  const double f = 6.25;
  for (const double alpha : {0.35, 0.6, 0.9}) {
    const WrenchLimits limits(v, alpha);
    EXPECT_EQ(limits.rank(), 6);
    const double s = std::sin(alpha), c = std::cos(alpha);
    const Vec3 vertices[] = {
        {4 * s * f, 4 * s * f, 0}, {0, 0, 8 * c * f}, {4 * s * f, 0, 4 * c * f}, {0, 4 * s * f, 4 * c * f}};
    for (const Vec3& force : vertices) {
      Vec6 w = Vec6::Zero();
      w.head<3>() = force;
      EXPECT_NEAR(limits.load(w), 1.0, 1e-9) << alpha << ": " << force.transpose();
    }
  }
}

TEST(WrenchLimits, LoadIsTheLeastLargestThrust) {
  // The load of A u never exceeds max |u| / f, and random allocations of the same wrench never beat it.
  const auto v = omnimorph();
  const WrenchLimits limits(v, 0.7);
  const Eigen::MatrixXd a = v.allocation_matrix(0.7);
  const Eigen::MatrixXd kernel = Eigen::FullPivLU<Eigen::MatrixXd>(a).kernel();
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXd u(8);
    for (int k = 0; k < 8; ++k) u[k] = random.uniform(-6.25, 6.25);
    const double load = limits.load(a * u);
    double best = 1e9;  // dense search over the two free directions
    for (int j = 0; j < 4000; ++j) {
      const Eigen::VectorXd z = Eigen::Vector2d(random.uniform(-12, 12), random.uniform(-12, 12));
      best = std::min(best, (u + kernel * z).cwiseAbs().maxCoeff() / 6.25);
    }
    best = std::min(best, u.cwiseAbs().maxCoeff() / 6.25);
    EXPECT_LE(load, best + 1e-9);
    EXPECT_GT(load, best - 0.25);
  }
}

TEST(WrenchLimits, OmnidirectionalFromTheTiltOfTheThesis) {
  auto v = vehicle::load_vehicle((kConfigs / "vehicles/omnimorph/omnimorph.yaml").string(), {"mass=1.595"})
               .value();
  for (auto& r : v.rotors) r.max_thrust = 5.95;
  v.center_of_mass.setZero();
  Random random(5);
  const auto worst = [&](double alpha_deg) {
    const WrenchLimits limits(v, to_radians(alpha_deg));
    double load = 0.0;
    for (int i = 0; i < 20000; ++i)
      load = std::max(load,
                      limits.hover_load(exp_rotation(Vec3(random.uniform(-3, 3), random.uniform(-3, 3), 0))));
    return load;
  };
  EXPECT_GT(worst(40.5), 1.0);
  EXPECT_LT(worst(41.5), 1.0);
}

TEST(WrenchLimits, AQuadrotorHoversUprightOnly) {
  vehicle::Vehicle v;
  v.mass = 0.03;
  v.inertia = Mat3::Identity() * 1e-5;
  for (int i = 0; i < 4; ++i) {
    vehicle::Rotor r;
    r.p_BR = Vec3(i < 2 ? 0.03 : -0.03, i % 2 ? 0.03 : -0.03, 0);
    r.spin = (i == 0 || i == 3) ? 1 : -1;
    r.drag_ratio = 0.006;
    r.thrust_coefficient = 1e-8;
    r.max_thrust = 0.15;
    v.rotors.push_back(r);
  }
  const WrenchLimits limits(v, 0.0);
  EXPECT_EQ(limits.rank(), 4);
  EXPECT_NEAR(limits.hover_load(Quat::Identity()), std::abs(0.03 * kGravity / 4 - 0.075) / 0.075, 1e-9);
  EXPECT_TRUE(std::isinf(limits.hover_load(exp_rotation(Vec3(0.05, 0, 0)))));
}

TEST(Spheres, CoverEveryPointOfDiscsAndShapes) {
  const auto v = omnimorph();
  const double alpha = 0.8;
  const auto spheres = cover_with_spheres(v, alpha);
  const auto covered = [&](const Vec3& p) {
    for (const auto& g : spheres.groups)
      for (const auto& s : g.spheres)
        if ((p - s.p_BS).norm() <= s.radius + 1e-9) return (p - g.bound.p_BS).norm() <= g.bound.radius + 1e-9;
    return false;
  };
  Random random(6);
  for (int i = 0; i < 4000; ++i) {
    const int k = static_cast<int>(random.next() % 8);
    const Vec3 n = v.rotor_axis(k, alpha), x = n.unitOrthogonal(), y = n.cross(x);
    const double a = random.uniform(0, 2 * kPi), r = v.rotors[0].radius * std::sqrt(random.uniform());
    EXPECT_TRUE(
        covered(v.rotors[static_cast<std::size_t>(k)].p_BR + r * (std::cos(a) * x + std::sin(a) * y)));
    const auto& shape = v.collision[random.next() % v.collision.size()];
    Vec3 p(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    if (shape.kind == vehicle::CollisionShape::Kind::box) {
      p = p.cwiseProduct(shape.size);
    } else {
      const double rr = shape.size.x() * std::sqrt(random.uniform());
      p = Vec3(rr * std::cos(a), rr * std::sin(a), p.z() * shape.size.y());
    }
    EXPECT_TRUE(covered(shape.p_BS + shape.q_BS * p));
  }
  EXPECT_GE(spheres.inscribed_radius, 0.069);
  EXPECT_LT(spheres.bounding_radius, v.bounding_radius() + 0.03);
}

TEST(StateCheck, ValidMotionsStayClearAtEveryPose) {
  const auto check = make_check(pyramid(), 45, 0.05);
  Random random(7);
  int accepted = 0;
  const auto pose = [&] {
    return Pose{Vec3(random.uniform(-2.5, 2.5), random.uniform(-2.5, 2.5), random.uniform(0.5, 2.5)),
                exp_rotation(Vec3(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)))};
  };
  for (int i = 0; i < 300; ++i) {
    const Pose a = pose(), b = pose();
    if (!check.motion_valid(a, b)) continue;
    ++accepted;
    for (int k = 0; k <= 500; ++k) ASSERT_GE(check.clearance(interpolate(a, b, k / 500.0)).distance, 0.05);
  }
  EXPECT_GT(accepted, 10);
}

TEST(StateCheck, NothingThatIsNotFiniteIsValid) {
  const auto check = make_check(pyramid(), 45, 0.05);
  EXPECT_TRUE(check.valid({Vec3(0, 0, 1.4), Quat::Identity()}));
  EXPECT_FALSE(check.valid({Vec3(NAN, 0, 1.4), Quat::Identity()}));
  EXPECT_FALSE(check.valid({Vec3(0, 0, 1.4), Quat(NAN, 0, 0, 0)}));
  EXPECT_FALSE(check.valid({Vec3(0, 0, 1.4), Quat(0, 0, 0, 0)}));
  EXPECT_FALSE(check.valid({Vec3(0, 0, INFINITY), Quat::Identity()}));
}

}  // namespace
}  // namespace omniflight::planning
