#include <gtest/gtest.h>

#include "bench.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::planning {
namespace {

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
