// A rigid body among triangles: what is called free is, judged triangle by triangle without spheres, field or
// tree.
#include "omniflight_planning/rigid_body.hpp"

#include <gtest/gtest.h>

#include "../src/triangle_tree.hpp"
#include "omniflight_core/random.hpp"
#include "repetitions.hpp"
#include "rigid_body_problems.hpp"

namespace omniflight::planning {
namespace {

Quat any_attitude(Random& random) {
  return Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
}

/// Least distance of any two triangles.
double brute_distance(const RigidBodyProblem& p, const Pose& pose) {
  double best = HUGE_VAL;
  for (std::size_t i = 0; i < p.body.triangles.size(); ++i) {
    Triangle t = p.body.corners(i);
    for (Vec3& corner : t) corner = pose.p_WB + pose.q_WB * corner;
    for (std::size_t k = 0; k < p.environment.triangles.size(); ++k)
      best = std::min(best, triangles_distance(t, p.environment.corners(k)));
  }
  return best;
}

Pose any_pose(const RigidBodyProblem& p, Random& random) {
  Pose out{Vec3::Zero(), any_attitude(random)};
  for (int k = 0; k < 3; ++k) out.p_WB[k] = random.uniform(p.lower[k], p.upper[k]);
  return out;
}

void expect_free(const RigidBodyProblem& p, const std::vector<Pose>& path, int steps) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    for (int k = 0; k <= steps; ++k)
      ASSERT_GT(brute_distance(p, interpolate(path[i], path[i + 1], static_cast<double>(k) / steps)), 0.0);
}

TEST(BodySpheres, HoldEveryPointOfTheSurfaceAndLieOnIt) {
  for (const TriangleMesh& body : {l_shaped_body(), rod(2.0, 0.02)}) {
    const VehicleSpheres spheres = cover_with_spheres(body);
    EXPECT_LE(spheres.groups.size(), 64u);
    EXPECT_EQ(spheres.inscribed_radius, 0.0);
    std::size_t count = 0;
    for (const SphereGroup& group : spheres.groups) {
      ASSERT_EQ(group.spheres.size(), group.triangles.size());
      count += group.spheres.size();
      for (std::size_t i = 0; i < group.spheres.size(); ++i) {
        EXPECT_LE(group.spheres[i].radius, 0.1 * spheres.bounding_radius + 1e-12);
        EXPECT_LT(point_triangle_distance(group.spheres[i].p_BS, group.triangles[i]), 1e-9);
        for (const Vec3& corner : group.triangles[i]) {
          EXPECT_LE((corner - group.spheres[i].p_BS).norm(), group.spheres[i].radius + 1e-12);
          EXPECT_LE((corner - group.bound.p_BS).norm(), group.bound.radius + 1e-12);
          EXPECT_LE(corner.norm(), spheres.bounding_radius + 1e-12);
        }
      }
    }
    EXPECT_LE(count, kMostBodySpheres);
    Random random(1);
    for (int i = 0; i < 5000; ++i) {  // the pieces leave no hole in the triangles that they were cut from
      const auto t = body.corners(
          static_cast<std::size_t>(random.uniform() * static_cast<double>(body.triangles.size())));
      double u = random.uniform(), v = random.uniform();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 p = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
      double nearest = HUGE_VAL;
      for (const SphereGroup& group : spheres.groups)
        for (std::size_t k = 0; k < group.triangles.size(); ++k)
          if ((p - group.spheres[k].p_BS).norm() <= group.spheres[k].radius + 1e-12)
            nearest = std::min(nearest, point_triangle_distance(p, group.triangles[k]));
      ASSERT_LT(nearest, 1e-9);
    }
  }
}

TEST(TriangleTree, TellsTheDistanceOfTheNearest) {
  Random random(2);
  const auto draw = [&](double size) {
    const Vec3 at(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    Triangle t;
    for (Vec3& p : t)
      p = at + size * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    return t;
  };
  std::vector<Triangle> all;
  for (int i = 0; i < 150; ++i) all.push_back(draw(0.1));
  const TriangleTree tree(all);
  for (int i = 0; i < 200; ++i) {
    const Triangle t = draw(0.2);
    double best = 10.0;
    for (const Triangle& other : all) best = std::min(best, triangles_distance(t, other));
    EXPECT_NEAR(tree.distance(t, 0.0, 10.0), best, 1e-12);
    EXPECT_NEAR(tree.distance(t, 0.0, 0.01), std::min(best, 0.01), 1e-12);
    const double quick = tree.distance(t, 0.05, 10.0);
    if (best > 0.05) {
      EXPECT_NEAR(quick, best, 1e-12);
    } else {
      EXPECT_LE(quick, 0.05);
    }
  }
}

TEST(RigidBody, PosesThatAreFreeTouchNothingAndTheOthersDoSo) {
  const RigidBodyProblem p = l_through_window(0.5, 0.5);
  const auto scene = RigidBodyScene::create(p);
  ASSERT_TRUE(scene) << scene.error().text();
  Random random(3);
  int free = 0, hit = 0;
  const double least = 2e-4 / scene->scale();
  for (int i = 0; i < 400 * times(); ++i) {
    Pose pose = any_pose(p, random);
    if (i % 2 == 0) pose.p_WB.x() = random.uniform(-0.3, 0.4);  // in and about the window
    if (i % 4 == 0) pose.p_WB.y() *= 0.15, pose.p_WB.z() = 1.2 + 0.3 * random.uniform(-1, 1);
    const double d = brute_distance(p, pose);
    if (scene->valid(pose)) {
      ++free;
      ASSERT_GT(d, 0.0);
      ASSERT_LE(scene->room(pose), d + 1e-9);
    } else {
      ++hit;
      ASSERT_LE(d, least * 1.01) << pose.p_WB.transpose();
    }
  }
  EXPECT_GT(free, 50 * times());
  EXPECT_GT(hit, 100 * times());
}

TEST(RigidBody, MotionsThatAreFreeTouchNothingOnTheWay) {
  const RigidBodyProblem p = l_through_window(0.8, 0.8);
  const auto scene = RigidBodyScene::create(p);
  ASSERT_TRUE(scene);
  Random random(4);
  int free = 0, refused = 0;
  for (int i = 0; i < 160 * times(); ++i) {
    const Pose a = any_pose(p, random);
    const Vec3 step(random.normal(), random.normal(), random.normal()),
        turn(random.normal(), random.normal(), random.normal());
    const Pose b{a.p_WB + 0.25 * step, (a.q_WB * exp_rotation(0.3 * turn)).normalized()};
    if (!scene->valid(a)) continue;
    if (scene->motion_valid(a, b)) {
      ++free;
      expect_free(p, {a, b}, 15);
    } else {
      ++refused;
      double nearest = HUGE_VAL;
      for (int k = 0; k <= 200; ++k)
        nearest = std::min(nearest, brute_distance(p, interpolate(a, b, k / 60.0)));
      const bool leaves = (b.p_WB - p.lower).minCoeff() < 0 || (p.upper - b.p_WB).minCoeff() < 0;
      EXPECT_TRUE(leaves || nearest < 0.02) << nearest;
    }
  }
  EXPECT_GT(free, 10);
  EXPECT_GT(refused, 10);
}

TEST(RigidBody, GetsThroughAWindowAndRoundBends) {
  for (const RigidBodyProblem& p : {l_through_window(0.8, 0.8), rod_in_bent_corridor(1.6)}) {
    const auto scene = RigidBodyScene::create(p);
    ASSERT_TRUE(scene) << scene.error().text();
    const PathOptions options{.seed = 1, .budget_s = 20.0, .deadline = Deadline(20.0), .name_of = {}};
    const auto path = scene->plan(options);
    ASSERT_TRUE(path) << path.error().message;
    EXPECT_EQ(path->front().p_WB, p.start.p_WB);
    EXPECT_EQ(path->back().p_WB, p.goal.p_WB);
    expect_free(p, *path, 60);
    for (const Pose& pose : *path) {
      EXPECT_GE((pose.p_WB - p.lower).minCoeff(), -1e-9);
      EXPECT_GE((p.upper - pose.p_WB).minCoeff(), -1e-9);
    }
    const auto again = scene->plan(options);
    ASSERT_TRUE(again);
    ASSERT_EQ(again->size(), path->size());
    for (std::size_t i = 0; i < path->size(); ++i) EXPECT_EQ((*again)[i].p_WB, (*path)[i].p_WB);
  }
}

TEST(RigidBody, IsTheSameProblemInAnyUnitAndPlace) {
  const RigidBodyProblem p = l_through_window(0.8, 0.8);
  RigidBodyProblem moved = p;
  const Vec3 by(5000, -200, 30);
  for (TriangleMesh* mesh : {&moved.environment, &moved.body}) mesh->scale(100.0);
  moved.environment.move(by);
  for (Pose* pose : {&moved.start, &moved.goal}) pose->p_WB = 100.0 * pose->p_WB + by;
  moved.lower = 100.0 * p.lower + by, moved.upper = 100.0 * p.upper + by;
  const auto scene = RigidBodyScene::create(p), other = RigidBodyScene::create(moved);
  ASSERT_TRUE(scene && other);
  // grids of voxels fall elsewhere, so that bounds of the room differ; verdicts do not
  Random random(5);
  int differ = 0, free = 0;
  for (int i = 0; i < 2000; ++i) {
    const Pose pose = any_pose(p, random);
    const bool here = scene->valid(pose), there = other->valid({100.0 * pose.p_WB + by, pose.q_WB});
    differ += here != there;
    free += here;
  }
  EXPECT_LE(differ, 2);  // within rounding of the least distance
  EXPECT_GT(free, 500);
}

TEST(RigidBody, GivesUpInTimeWhereNothingFits) {
  const RigidBodyProblem p = l_through_window(0.08, 1.0);  // the bars are 0.1 m thick
  const auto scene = RigidBodyScene::create(p);
  ASSERT_TRUE(scene);
  const Deadline watch(100.0);
  const auto path = scene->plan({.budget_s = 0.5, .deadline = Deadline(0.5), .name_of = {}});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().failure, PathFailure::no_path_in_time);
  EXPECT_LT(100.0 - watch.left(), 20.0);  // s; the machine may be busy
}

TEST(RigidBody, RefusesWhatIsNoProblem) {
  const auto why = [](const RigidBodyProblem& p) {
    const auto scene = RigidBodyScene::create(p);
    if (scene) return std::string("accepted");
    EXPECT_EQ(scene.error().code, ErrorCode::bad_input);
    return scene.error().text();
  };
  const RigidBodyProblem good = l_through_window(0.8, 0.8);
  RigidBodyProblem p = good;
  p.start.p_WB.x() = NAN;
  EXPECT_NE(why(p).find("not finite"), std::string::npos);
  p = good, p.goal.p_WB.x() = 3.0;
  EXPECT_NE(why(p).find("outside of the box"), std::string::npos);
  p = good, p.upper.z() = NAN;
  EXPECT_NE(why(p), "accepted");
  p = good, p.lower = p.upper;
  EXPECT_NE(why(p), "accepted");
  p = good, p.body.triangles.clear();
  EXPECT_NE(why(p).find("no triangle"), std::string::npos);
  p = good, p.environment.move(Vec3(100, 0, 0));
  EXPECT_NE(why(p).find("no obstacle at all"), std::string::npos);
  p = good, p.body.scale(0.0);
  EXPECT_NE(why(p).find("a point"), std::string::npos);
  p = good, p.start.p_WB.x() = 0.05, p.start.p_WB.y() = 1.0;
  const auto scene = RigidBodyScene::create(p);
  ASSERT_TRUE(scene);
  const auto path = scene->plan({.name_of = {}});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().failure, PathFailure::start_occupied);
}

}  // namespace
}  // namespace omniflight::planning
