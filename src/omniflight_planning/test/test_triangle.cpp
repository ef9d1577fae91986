// Triangles against boxes and one another, judged by points of them.
#include "../src/triangle.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "omniflight_core/random.hpp"

namespace omniflight::planning {
namespace {

Vec3 any(Random& random, double size) {
  return size * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
}
Triangle any_triangle(Random& random, double size) {
  const Vec3 at = any(random, 1.0);
  return {at + any(random, size), at + any(random, size), at + any(random, size)};
}
Vec3 point_of(const Triangle& t, double u, double v) {
  if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
  return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
}

TEST(Triangle, NeverMissesABoxThatAPointOfItLiesIn) {
  Random random(1);
  int inside = 0, apart = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Triangle t = any_triangle(random, 0.8);
    const Vec3 center = any(random, 1.0), half = Vec3::Constant(random.uniform(0.01, 0.4));
    const Vec3 p = point_of(t, random.uniform(), random.uniform());
    if (((p - center).cwiseAbs().array() <= half.array()).all()) {
      ++inside;
      EXPECT_TRUE(touches_box(t, center, half));
    }
    apart += !touches_box(t, center, half);
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(apart, 3000);
}

TEST(Triangle, TouchesNoBoxThatItIsFarFrom) {
  // separating axes are exact for convex bodies: beyond the largest distance of a sphere there is one
  Random random(2);
  int looked = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Triangle t = any_triangle(random, 0.8);
    const Vec3 center = any(random, 1.5);
    const double half = random.uniform(0.01, 0.3);
    if (point_triangle_distance(center, t) <= std::sqrt(3.0) * half + 1e-6) continue;
    ++looked;
    EXPECT_FALSE(touches_box(t, center, Vec3::Constant(half)));
  }
  EXPECT_GT(looked, 5000);
}

TEST(Triangle, TouchesTheBoxWhoseFaceItLiesIn) {
  const Triangle wall{Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, 0, 1)};
  EXPECT_TRUE(touches_box(wall, Vec3(0.5, 0.2, 0.2), Vec3::Constant(0.5)));
  EXPECT_TRUE(touches_box(wall, Vec3(1.5, 0.2, 0.2), Vec3::Constant(0.5)));
  EXPECT_FALSE(touches_box(wall, Vec3(1.5 + 1e-6, 0.2, 0.2), Vec3::Constant(0.5)));
}

TEST(Triangle, DegenerateOnesAreSegmentsAndPoints) {
  const Triangle segment{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 0, 0)},
      point{Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)};
  EXPECT_TRUE(touches_box(segment, Vec3(0.3, 0.05, 0), Vec3::Constant(0.06)));
  EXPECT_FALSE(touches_box(segment, Vec3(0.3, 0.2, 0), Vec3::Constant(0.06)));
  EXPECT_TRUE(touches_box(point, Vec3(1, 1, 1), Vec3::Constant(0.1)));
  EXPECT_NEAR(triangles_distance(segment, point), std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(point_triangle_distance(Vec3(0.5, 2, 0), segment), 2.0, 1e-12);
}

TEST(Triangle, DistanceIsNeverMoreThanThatOfTwoPointsAndIsReached) {
  Random random(3);
  int apart = 0, meeting = 0;
  for (int i = 0; i < 200; ++i) {
    const Triangle a = any_triangle(random, 0.7), b = any_triangle(random, 0.7);
    const double d = triangles_distance(a, b);
    EXPECT_NEAR(triangles_distance(b, a), d, 1e-12);
    double best = HUGE_VAL;  // of points 1/60 of an edge apart
    constexpr int kN = 30;
    std::vector<Vec3> of_a;
    for (int u = 0; u <= kN; ++u)
      for (int v = 0; u + v <= kN; ++v) of_a.push_back(point_of(a, u / double(kN), v / double(kN)));
    for (const Vec3& p : of_a) best = std::min(best, point_triangle_distance(p, b));
    EXPECT_LE(d, best + 1e-12);
    EXPECT_GE(d, best - 2.5 / kN);
    (d > 0.0 ? apart : meeting)++;
  }
  EXPECT_GT(apart, 60);
  EXPECT_GT(meeting, 4);
}

TEST(Triangle, OfOnePlaneAndOverlappingOnesHaveNoDistance) {
  const Triangle a{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)},
      inside{Vec3(0.2, 0.2, 0), Vec3(0.4, 0.2, 0), Vec3(0.2, 0.4, 0)};
  EXPECT_LE(triangles_distance(a, inside), 1e-12);
  const Triangle above{Vec3(0.2, 0.2, 0.3), Vec3(0.4, 0.2, 0.3), Vec3(0.2, 0.4, 0.3)};
  EXPECT_NEAR(triangles_distance(a, above), 0.3, 1e-12);
}

TEST(Triangle, ParallelSegmentsThatOverlapAndThatDoNot) {
  EXPECT_NEAR(segments_distance(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 1, 0), Vec3(3, 1, 0)), 1.0, 1e-12);
  EXPECT_NEAR(segments_distance(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(4, 4, 0), Vec3(8, 4, 0)), 5.0, 1e-12);
  EXPECT_NEAR(segments_distance(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(-7, 1, 0), Vec3(7, 1, 0)), 1.0, 1e-12);
}

}  // namespace
}  // namespace omniflight::planning
