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
        if ((p - s.p_BS).norm() <= s.radius + 1e-9 && (p - g.bound.p_BS).norm() <= g.bound.radius + 1e-9)
          return true;
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

/// Points on the rims of the rotor discs, on the edges of the boxes and on the cylinders' ends, world frame.
std::vector<Vec3> outline(const VehicleSpheres& vehicle, const Pose& pose) {
  std::vector<Vec3> out;
  const auto add = [&](const vehicle::CollisionShape& s, const Vec3& p) {
    out.push_back(pose.p_WB + pose.q_WB * (s.p_BS + s.q_BS * p));
  };
  for (const auto& group : vehicle.groups) {
    const auto& s = group.part;
    if (s.kind == vehicle::CollisionShape::Kind::cylinder)
      for (int k = 0; k < 90; ++k)
        for (const double end : {-0.5, 0.5})
          add(s,
              {s.size.x() * std::cos(k * kPi / 45), s.size.x() * std::sin(k * kPi / 45), end * s.size.y()});
    if (s.kind == vehicle::CollisionShape::Kind::box)
      for (int axis = 0; axis < 3; ++axis)
        for (int edge = 0; edge < 4; ++edge)
          for (int k = 0; k <= 20; ++k) {
            Vec3 p;
            p[axis] = 0.05 * k - 0.5;
            p[(axis + 1) % 3] = (edge & 1) - 0.5;
            p[(axis + 2) % 3] = (edge >> 1) - 0.5;
            add(s, p.cwiseProduct(s.size));
          }
  }
  return out;
}

/// A wall with a window, wider by nothing than `width` [m]: its faces lie on the faces of voxels.
DistanceMap window(double width, double resolution) {
  const TestBed bed = window_bed(width, width, resolution);
  return DistanceMap::create(*make_octree(bed).value(), "").value();
}

TEST(StateCheck, MeasuresThePartsThemselvesWhereSpheresCannotTell) {
  const auto map = window(0.5, 0.02);
  const auto check = make_check(map, 30, 0.02);
  const auto boxes = [&] {
    std::vector<Vec3> out;
    map.for_surface(kWindow - Vec3::Constant(0.4), kWindow + Vec3::Constant(0.4),
                    [&](const Vec3& c) { out.push_back(c); });
    return out;
  }();
  Random random(11);
  int near = 0, spheres_too_large = 0;
  for (int i = 0; i < 6; ++i) {
    const double far = i % 2 == 0 ? 0.1 : 1.0;
    const Pose pose{
        kWindow + 0.05 * far * Vec3(random.normal(), 0.2 * random.normal(), 0.2 * random.normal()),
        exp_rotation(0.08 * far * Vec3(random.normal(), random.normal(), random.normal()))};
    double sampled = 1.0;
    for (const Vec3& p : outline(check.spheres(), pose))
      for (const Vec3& c : boxes)
        sampled = std::min(sampled, ((p - c).cwiseAbs().array() - 0.01).max(0.0).matrix().norm());
    const double told = check.clearance(pose).distance, room = check.room(pose);
    ASSERT_LE(told, sampled + 1e-9);  // never too large
    if (told > 0) {                   // nor smaller than the outline's samples leave open
      ASSERT_GE(told, sampled - 2e-3);
    }
    ASSERT_LE(room, std::max(0.0, sampled - 0.02) + 1e-9);
    if (told > 0.0205) {  // free is told as free
      ASSERT_GT(room, 0.0) << told;
    }
    near += told > 0.02;
    double by_spheres = 1.0;
    for (const auto& group : check.spheres().groups)
      for (const auto& s : group.spheres)
        by_spheres = std::min(by_spheres, map.distance(pose.p_WB + pose.q_WB * s.p_BS) - s.radius);
    spheres_too_large += told > 0.02 && by_spheres <= 0.02;
  }
  EXPECT_GE(near, 2);
  EXPECT_EQ(near, spheres_too_large) << "spheres alone lose every one of these poses";
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

/// Free at both ends and in collision for a moment in between: what checks at intervals may miss.
TEST(StateCheck, NoMotionThroughANetOrPastARopeIsAccepted) {
  TestBed bed;
  bed.name = "net";
  bed.resolution = 0.02;
  bed.lower = Vec3(-1.2, -0.8, 0);
  bed.upper = Vec3(1.2, 0.8, 1.6);
  const auto wire = [&](const Vec3& a, const Vec3& b, double radius) {
    bed.primitives.push_back({Primitive::Kind::capsule, "wire", a, b, radius});
  };
  for (double at = -0.75; at < 0.8; at += 0.15) {  // wires of 12 mm every 0.15 m, across the whole room
    wire({0, at, 0}, {0, at, 1.6}, 0.006);
    wire({0, -0.8, at + 0.8}, {0, 0.8, at + 0.8}, 0.006);
  }
  wire({0.86, 0, 0}, {0.86, 0, 1.6}, 0.008);  // a rope
  const auto map = DistanceMap::create(*make_octree(bed).value(), "").value();
  const auto check = make_check(map, 50, 0.02);
  Random random(5);
  int edges = 0, accepted = 0;
  while (edges < 200) {
    const auto pose = [&](double side) {
      return Pose{Vec3(side * random.uniform(0.36, 0.5), random.uniform(-0.4, 0.4), random.uniform(0.4, 1.2)),
                  exp_rotation(Vec3(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)))};
    };
    Pose a = pose(-1), b = pose(1);
    if (edges % 2 == 0)
      b.q_WB = a.q_WB = from_roll_pitch_yaw(Vec3(0, kPi / 2, 0));  // thin discs, along their normal
    if (!check.valid(a) || !check.valid(b)) continue;
    ++edges;
    accepted += check.motion_valid(a, b);
  }
  EXPECT_EQ(accepted, 0);
  // a quarter turn in place: the rope stands between two rotors before and after
  const auto turned = [](double yaw) { return Pose{{0.61, 0, 0.8}, from_roll_pitch_yaw(Vec3(0, 0, yaw))}; };
  EXPECT_TRUE(check.valid(turned(0)));
  EXPECT_TRUE(check.valid(turned(kPi / 2)));
  EXPECT_FALSE(check.valid(turned(kPi / 4)));
  EXPECT_FALSE(check.motion_valid(turned(0), turned(kPi / 2)));
  // and what stays on one side is accepted
  EXPECT_TRUE(check.motion_valid({{-0.6, -0.3, 0.6}, Quat::Identity()},
                                 {{-0.6, 0.3, 1.0}, from_roll_pitch_yaw(Vec3(0.5, 0, 1))}));
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
