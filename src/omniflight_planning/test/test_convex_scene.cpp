// Convex parts: their distance against that of their triangles, whole motions against dense samples of them.
#include "../src/convex_scene.hpp"

#include <gtest/gtest.h>

#include "../src/pose_index.hpp"
#include "omniflight_core/random.hpp"
#include "repetitions.hpp"
#include "rigid_body_problems.hpp"

namespace omniflight::planning {
namespace {

constexpr double kLeast = 2e-4;  // m

Quat any_turn(Random& random) {
  return Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
}
Vec3 any_place(Random& random, double size) {
  return size * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
}
/// At most `size` [m] and [rad] from another pose.
Pose near_to(const Pose& pose, double size, Random& random) {
  return {pose.p_WB + any_place(random, size),
          (pose.q_WB * exp_rotation(any_place(random, size))).normalized()};
}

TriangleMesh box(const Vec3& half) {
  TriangleMesh mesh;
  add_box(mesh, -half, half);
  return mesh;
}

struct Cloud {
  std::vector<double> x, y, z;
  explicit Cloud(const std::vector<Vec3>& points) {
    for (const Vec3& p : points) x.push_back(p.x()), y.push_back(p.y()), z.push_back(p.z());
  }
  PointsView view() const { return {x.data(), y.data(), z.data(), static_cast<int>(x.size())}; }
};

double distance_of_surfaces(const TriangleMesh& a, const Pose& at, const TriangleMesh& b) {
  double best = HUGE_VAL;
  for (std::size_t i = 0; i < a.triangles.size(); ++i) {
    Triangle t = a.corners(i);
    for (Vec3& p : t) p = at.p_WB + at.q_WB * p;
    for (std::size_t k = 0; k < b.triangles.size(); ++k)
      best = std::min(best, triangles_distance(t, b.corners(k)));
  }
  return best;
}

TEST(Separation, IsTheDistanceOfTheSurfacesFromAnyFirstAxis) {
  Random random(1);
  const TriangleMesh fixed = box(Vec3(0.8, 0.6, 0.3));
  TriangleMesh sheet;  // a triangle has no inside
  sheet.vertices = {Vec3(-0.4, -0.3, 0), Vec3(0.5, 0, 0), Vec3(0, 0.4, 0)};
  sheet.triangles = {{0, 1, 2}};
  int apart = 0, touching = 0;
  for (const TriangleMesh& body : {box(Vec3(0.5, 0.03, 0.03)), box(Vec3(0.2, 0.3, 0.4)), sheet})
    for (int i = 0; i < 1500; ++i) {
      Pose pose{any_place(random, 1.3), any_turn(random)};
      if (i % 5 == 0) pose.q_WB = Quat::Identity();  // parallel faces
      if (i % 25 == 0) pose.p_WB = any_place(random, 0.1) + Vec3(0, 0, 0.33 + 0.1 * random.uniform());
      std::vector<Vec3> points;
      for (const Vec3& p : body.vertices) points.push_back(pose.p_WB + pose.q_WB * p);
      const Cloud a(points), b(fixed.vertices);
      Vec3 axis = any_turn(random) * Vec3::UnitX();
      const double gap = separation(a.view(), b.view(), axis, kLeast, 10.0);
      const double truth = distance_of_surfaces(body, pose, fixed);
      const bool inside = (pose.p_WB.cwiseAbs() - Vec3(0.8, 0.6, 0.3)).maxCoeff() < 0.0;
      if (inside || truth <= kLeast) {
        ASSERT_LE(gap, kLeast);
        ++touching;
        continue;
      }
      ++apart;
      ASSERT_LE(gap, truth + 1e-9);
      ASSERT_GE(gap, 0.9 * truth - 1e-6);
      ASSERT_NEAR(axis.norm(), 1.0, 1e-9);
      double lowest = HUGE_VAL;
      for (const Vec3& p : points) lowest = std::min(lowest, axis.dot(p));
      ASSERT_NEAR(lowest - reach_along(b.view(), axis), gap, 1e-12);  // the gap along that axis
    }
  EXPECT_GT(apart, 1000);
  EXPECT_GT(touching, 500);
}

TEST(ConvexParts, AreTheClosedConvexComponents) {
  const MeshParts body = parts_of(l_shaped_body()), room = parts_of(window_room(0.5, 0.5));
  EXPECT_EQ(body.solids.size(), 2u);
  EXPECT_EQ(room.solids.size(), 10u);
  EXPECT_TRUE(body.triangles.empty() && room.triangles.empty());
  const MeshParts one = parts_of(box(Vec3(1, 2, 3)));
  ASSERT_EQ(one.solids.size(), 1u);
  EXPECT_EQ(one.solids[0].points.size(), 8u);
  EXPECT_TRUE(one.solids[0].holds(Vec3(0.99, -1.99, 2.99)));
  EXPECT_FALSE(one.solids[0].holds(Vec3(1.01, 0, 0)));
}

TEST(ConvexParts, AreNoneWhereTheSurfaceIsOpenOrNotConvex) {
  TriangleMesh open = box(Vec3(1, 1, 1));
  open.triangles.pop_back();
  EXPECT_TRUE(parts_of(open).solids.empty());
  EXPECT_EQ(parts_of(open).triangles.size(), 11u);
  TriangleMesh dented = box(Vec3(1, 1, 1));
  dented.vertices[7] = Vec3(0.1, 0.1, 0.1);
  EXPECT_TRUE(parts_of(dented).solids.empty());
  TriangleMesh flat = box(Vec3(1, 1, 1));
  flat.vertices[1] = flat.vertices[0];  // triangles without area
  EXPECT_TRUE(parts_of(flat).solids.empty());
}

TEST(ConvexParts, MayShareACorner) {
  TriangleMesh two = box(Vec3(1, 1, 1));
  add_box(two, Vec3(1, 1, 1), Vec3(2, 2, 2));
  for (auto& t : two.triangles)
    for (auto& v : t)
      if (v == 8) v = 7;  // the same point
  EXPECT_EQ(parts_of(two).solids.size(), 2u);
}

struct Scene {
  TriangleMesh body, world;
  ConvexScene scene;
  SeparationMemory memory = {};
  Scene(TriangleMesh b, TriangleMesh w)
      : body(std::move(b)), world(std::move(w)), scene(parts_of(body), parts_of(world)) {}
  bool free(const Pose& pose) { return scene.free(pose, kLeast, memory); }
  bool motion_free(const Pose& a, const Pose& b) { return scene.motion_free(a, b, kLeast, memory); }
};

/// Sheets, a net of 12 mm bars and thin discs in the way, whose edges are met first.
TriangleMesh thin_things() {
  TriangleMesh mesh;
  for (int i = -3; i <= 3; ++i) {
    const double at = 0.15 * i;
    add_box(mesh, Vec3(0.494, at - 0.006, -0.5), Vec3(0.506, at + 0.006, 0.5));
    add_box(mesh, Vec3(0.494, -0.5, at - 0.006), Vec3(0.506, 0.5, at + 0.006));
  }
  add_box(mesh, Vec3(-0.7, -0.5, -0.5), Vec3(-0.6999, 0.5, 0.5));
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(-0.4, 0.3, 0.3), Vec3(0.4, 0.3, 0.3), Vec3(0, 0.7, 0.3)});
  mesh.triangles.push_back({first, first + 1, first + 2});  // a loose triangle
  return mesh;
}

TEST(ConvexScene, PosesAreFreeWhereNoTrianglesAreNear) {
  Random random(2);
  Scene s(l_shaped_body(), thin_things());
  int free = 0, hit = 0;
  for (int i = 0; i < 150 * times(); ++i) {
    const Pose pose{any_place(random, 0.9), any_turn(random)};
    const double truth = distance_of_surfaces(s.body, pose, s.world);
    if (std::abs(truth - kLeast) < 2e-6) continue;
    const bool told = s.free(pose);
    // no part can be inside of another one here: the obstacles are thinner than the body
    ASSERT_EQ(told, truth > kLeast) << truth;
    (told ? free : hit)++;
  }
  EXPECT_GT(free, 15 * times());
  EXPECT_GT(hit, 15 * times());
}

TEST(ConvexScene, MotionsAreFreeAsAWholeOrRefused) {
  Random random(3);
  TriangleMesh disc = box(Vec3(0.2, 0.2, 5e-5));
  for (const TriangleMesh& body : {l_shaped_body(), rod(0.8, 0.02), disc}) {
    Scene s(body, thin_things());
    int free = 0, refused = 0, wrongly = 0;
    for (int i = 0; i < 6000 && free + refused < 1200; ++i) {
      Pose a{any_place(random, 0.9), any_turn(random)};
      if (!s.free(a)) continue;
      Pose b = near_to(a, i % 3 == 0 ? 0.5 : 0.15, random);
      if (i % 4 == 0) b.p_WB = a.p_WB;                                                    // turns only
      if (i % 4 == 1) b.q_WB = a.q_WB, b.p_WB = a.p_WB + 0.3 * (a.q_WB * Vec3::UnitZ());  // along its normal
      bool sampled = true;
      for (int k = 0; k <= 400 && sampled; ++k) sampled = s.free(interpolate(a, b, k / 400.0));
      const bool told = s.motion_free(a, b);
      ASSERT_TRUE(sampled || !told);
      (told ? free : refused)++;
      wrongly += sampled && !told;  // or hit between two samples
    }
    EXPECT_GT(free, 100);
    EXPECT_GT(refused, 100);
    EXPECT_LT(wrongly, 24);
  }
}

TEST(ConvexScene, ABodyMayMoveInsideOfAClosedSurface) {
  RigidBodyProblem p{box(Vec3(1, 1, 1)),
                     box(Vec3(0.3, 0.05, 0.05)),
                     {Vec3(-0.5, 0.5, 0), Quat::Identity()},
                     {Vec3(0.5, -0.5, 0.3), from_roll_pitch_yaw(Vec3(0, 0, 1.2))},
                     Vec3(-1, -1, -1),
                     Vec3(1, 1, 1)};
  const auto scene = RigidBodyScene::create(p);
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_TRUE(scene->plan({.name_of = {}}));
  EXPECT_FALSE(scene->valid({Vec3(0.8, 0, 0), Quat::Identity()}));  // through the wall
  p.start.p_WB = p.goal.p_WB = Vec3(0, 0, 1.5), p.goal.p_WB.x() = 0.3;
  p.lower.z() = -2, p.upper.z() = 2;
  const auto outside = RigidBodyScene::create(p);
  ASSERT_TRUE(outside);
  EXPECT_TRUE(outside->plan({.name_of = {}}));
  EXPECT_FALSE(outside->valid({Vec3(0, 0, 0), Quat::Identity()}));  // where nothing gets from outside
}

TEST(PoseIndex, FindsAPoseThatIsAlmostTheNearest) {
  Random random(4);
  PoseIndex index;
  std::vector<Pose> poses;
  double worst = 1.0;
  for (int i = 0; i < 3000; ++i) {
    Pose pose{any_place(random, 1.0), any_turn(random)};
    if (i % 7 == 0 && i > 0) pose = poses.back();
    if (i % 2 == 0) pose.q_WB.coeffs() *= -1.0;
    if (i > 0 && i % 3 == 0) {
      const Pose to{any_place(random, 1.0), any_turn(random)};
      double best = HUGE_VAL;
      for (const Pose& other : poses) best = std::min(best, pose_distance(to, other));
      worst = std::max(worst, pose_distance(to, poses[index.near(to)]) / best);
    }
    index.add(pose);
    poses.push_back(pose);
  }
  EXPECT_EQ(index.size(), 3000u);
  EXPECT_LE(worst, 1.0 + PoseIndex::kSlack + 1e-4);
  PoseIndex alike;
  for (int i = 0; i < 100; ++i) alike.add(poses[0]);
  EXPECT_LT(alike.near(poses[1]), 100u);
}

}  // namespace
}  // namespace omniflight::planning
